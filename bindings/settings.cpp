#include "settings.hpp"

#include <nanobind/stl/vector.h>
#include <algorithm>

static Metric make_metric(int m, int n, nb::handle rows, nb::handle units, nb::handle columns, nb::handle joints) {
  auto data = std::make_shared<MetricData>();
  data->m = m;
  data->n = n;
  const auto copy = [](const char* name, nb::handle from, std::initializer_list<long> shape, std::vector<double>& to) {
    if (from.is_none()) return;
    const View view = strict(name, from, shape, false);
    std::size_t count = 1;
    for (long s : shape) count *= to_size(s);
    to.assign(view.data(), view.data() + count);
  };
  copy("rows", rows, {m, m}, data->rows);
  copy("units", units, {n}, data->units);
  copy("columns", columns, {n}, data->columns);
  copy("joints", joints, {n, n}, data->joints);
  const auto last = std::find_if(data->rows.rbegin(), data->rows.rend(), [](double weight) { return weight != 0.0; });
  data->weightless = static_cast<int>(last - data->rows.rbegin()) / m;
  if (!data->joints.empty() && data->units.empty()) data->units.assign(to_size(n), 1.0);
  return {std::move(data)};
}

void bind_settings(nb::module_& m) {
  nb::class_<Law>(m, "Law", "Settings of a law, as the core reads them.")
      .def(
          "__init__",
          [](Law* law, stillreach::LawKind kind, stillreach::DampingKind damping, stillreach::NormKind norm,
             double kappa, double rank_tolerance, std::vector<int> part, std::vector<double> price, int capped,
             double ceiling, double beyond) {
            stillreach::LawSettings s{kind, damping, norm,   kappa,   rank_tolerance, static_cast<int>(price.size()),
                                      {},   {},      capped, ceiling, beyond};
            for (std::size_t g = 0; g < price.size() && g < stillreach::kParts; ++g) s.price[g] = price[g];
            for (std::size_t r = 0; r < part.size() && r < 6; ++r) s.part[r] = static_cast<std::int8_t>(part[r]);
            new (law) Law{s};
          },
          nb::arg("kind"), nb::kw_only(), nb::arg("damping") = stillreach::DampingKind::NUMBER,
          nb::arg("norm") = stillreach::NormKind::MAXIMUM, nb::arg("kappa") = 0.0, nb::arg("rank_tolerance") = 1e-10,
          nb::arg("part") = std::vector<int>{}, nb::arg("price") = std::vector<double>{}, nb::arg("capped") = -1,
          nb::arg("ceiling") = 0.0, nb::arg("beyond") = 0.0);
  nb::class_<Metric>(m, "Metric", "Units and weights of m task rows and n joints.")
      .def(
          "__init__",
          [](Metric* self, int rows_count, int n, nb::handle rows, nb::handle units, nb::handle columns,
             nb::handle joints) { new (self) Metric(make_metric(rows_count, n, rows, units, columns, joints)); },
          nb::arg("m"), nb::arg("n"), nb::kw_only(), nb::arg("rows").none() = nb::none(),
          nb::arg("units").none() = nb::none(), nb::arg("columns").none() = nb::none(),
          nb::arg("joints").none() = nb::none())
      .def_prop_ro(
          "weightless", [](const Metric& self) { return self.data->weightless; },
          "Rank that the weight of the rows lacks: 0 where it is positive definite.");
}
