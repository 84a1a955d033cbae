// law.solve: one answer for a Jacobian from anywhere.
#include <cstring>

#include "solution.hpp"

static Solution solve(const Law& law, const Metric& metric, nb::handle J, nb::handle twist, nb::handle lower, nb::handle upper,
                      nb::handle reference, nb::handle start) {
  const int m = metric.data->m, n = metric.data->n;
  Solution s;
  s.metric = metric.data, s.m = m, s.n = n, s.rank_tolerance = law.settings.rank_tolerance;
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
  static thread_local Scratch scratch;
  scratch.fit(n, !metric.data->joints.empty());
  s.rates = new_vector(n);
  View rates;
  rates.open(s.rates);
  std::int8_t* const reasons = s.reasons();
  std::memset(reasons, 0, n);
  if (!start.is_none())
    for (int i = 0; i < n; ++i) {
      const int code = nb::cast<int>(nb::int_(start[i]));
      reasons[i] = static_cast<std::int8_t>(code > 0 ? 1 : code < 0 ? -1 : 0);
    }
  const stillreach::Problem p{m, n, s.jacobian(), s.twist(), s.lower(), s.upper(), reference.is_none() ? nullptr : nearby.data(),
                              metric.data->view()};
  stillreach::Answer out{rates.data(), s.residual(), reasons, 0, 0, 0.0, 1.0, 0.0};
  kernel().solve(law.settings, p, scratch.memory(), out);
  s.status = out.status, s.iterations = out.iterations, s.damping = out.damping, s.scale = out.scale, s.task_error = out.task_error;
  for (int i = 0; i < n; ++i)
    reasons[i] = reasons[i] == 2 ? std::int8_t{stillreach::FAULT} : active_reason(reasons[i], stillreach::RATE, stillreach::RATE);
  return s;
}

void bind_solve(nb::module_& m) {
  m.def("solve", &solve, nb::arg("law"), nb::arg("metric"), nb::arg("J"), nb::arg("twist"), nb::arg("lower"), nb::arg("upper"),
        nb::arg("reference").none() = nb::none(), nb::arg("start").none() = nb::none(),
        "One answer of a law: J (m, n), twist (m,), lower, upper (n,), reference (n,) or None, start: the active bounds of an "
        "earlier answer or None.");
}
