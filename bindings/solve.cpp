// law.solve: one answer for a Jacobian from anywhere.
#include <algorithm>

#include "solution.hpp"

static Solution solve(const Law& law, const Metric& metric, nb::handle J, nb::handle twist, nb::handle lower,
                      nb::handle upper, nb::handle reference, nb::handle start, double typical) {
  const int m = metric.data->m, n = metric.data->n;
  Solution s;
  s.metric = metric.data;
  s.m = m;
  s.n = n;
  s.rank_tolerance = law.settings.rank_tolerance;
  s.make_room();
  {
    const View rows = strict("J", J, {m, n}, false);
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < m; ++r) s.jacobian()[i * m + r] = rows.data()[r * n + i];
  }
  read_vector("twist", twist, m, s.twist());
  read_vector("lower", lower, n, s.lower(), false);
  read_vector("upper", upper, n, s.upper(), false);
  View nearby;
  if (!reference.is_none()) nearby = strict("reference", reference, {n}, false);
  s.rates = new_vector(n);
  View rates;
  rates.open(s.rates);
  std::int8_t* const reasons = s.reasons();
  std::fill_n(reasons, n, std::int8_t{0});
  if (!start.is_none()) {
    const View codes = strict("start", start, {n}, false);
    for (int i = 0; i < n; ++i)
      reasons[i] = static_cast<std::int8_t>(codes.data()[i] > 0.0 ? 1 : codes.data()[i] < 0.0 ? -1 : 0);
  }
  static thread_local stillreach::WorkspaceMemory kept;
  Lease<stillreach::WorkspaceMemory> scratch(kept);
  scratch->fit(n, !metric.data->joints.empty());
  const stillreach::Problem p{m,
                              n,
                              s.jacobian(),
                              s.twist(),
                              s.lower(),
                              s.upper(),
                              reference.is_none() ? nullptr : nearby.data(),
                              metric.data->view(),
                              typical};
  stillreach::Multiplier multiplier{};
  stillreach::Answer out{rates.data(), s.residual(), reasons, 0, 0, 0.0, 1.0, 0.0, &multiplier};
  kernel().solve(law.settings, p, scratch->view(), out);
  s.status = out.status;
  s.iterations = out.iterations;
  s.damping = out.damping;
  s.scale = out.scale;
  s.task_error = out.task_error;
  s.set_multiplier(multiplier);
  for (int i = 0; i < n; ++i) reasons[i] = stillreach::bound_reason(reasons[i]);
  return s;
}

void bind_solve(nb::module_& m) {
  m.def("solve", &solve, nb::arg("law"), nb::arg("metric"), nb::arg("J"), nb::arg("twist"), nb::arg("lower"),
        nb::arg("upper"), nb::arg("reference").none() = nb::none(), nb::arg("start").none() = nb::none(),
        nb::arg("typical") = -1.0,
        "One answer of a law: J (m, n), twist (m,), lower, upper (n,), reference (n,) or None, start: the active "
        "bounds of an "
        "earlier answer or None, typical: what the working joints' rates are worth; below 0: as the bounds say.");
  m.def(
      "typical_rate",
      [](const Metric& metric, nb::handle limits) {
        const int n = metric.data->n;
        std::vector<double> upper(to_size(n)), lower(to_size(n));
        read_vector("velocity_limits", limits, n, upper.data(), false);
        std::transform(upper.begin(), upper.end(), lower.begin(), [](double limit) { return -limit; });
        return kernel().typical_rate(n, lower.data(), upper.data(), metric.data->view());
      },
      nb::arg("metric"), nb::arg("limits"), "The second largest of the rate limits (n,), in weighted units.");
}
