// solve_batch: rows in parallel, without the interpreter's lock.
#include "batch.hpp"

#include <nanobind/stl/pair.h>

BatchScratch& batch_scratch() {
  static thread_local BatchScratch scratch;
  return scratch;
}

namespace {

void set_bounds(stillreach::Batch& b, Arrays& in, long count, long n) {
  b.lower = in.rows("lower", count, n, b.bounds_stride);
  std::ptrdiff_t upper_stride;
  b.upper = in.rows("upper", count, n, upper_stride);
  if (upper_stride != b.bounds_stride) refuse("upper", "another shape", "the shape of lower");
}

void solve_batch(const Law& law, const Metric& metric, nb::handle arm, nb::sequence rows, bool tool_axes, long count,
                 nb::dict given, nb::dict answers, int threads) {
  stillreach::Batch b{};
  const long n = metric.data->n, m = metric.data->m;
  Arrays in(given), out(answers);
  set_task(b, law, metric, rows, tool_axes);
  std::ptrdiff_t ignored;
  if (!arm.is_none()) {
    const Arm& model = nb::cast<const Arm&>(arm);
    if (model.n() != n) refuse("arm", std::to_string(model.n()) + " joints", std::to_string(n) + ", as the metric has");
    b.arm = model.view();
    b.q = in.numbers("q", {count, n}, false);
    b.twist = in.rows("twist", count, 6, b.twist_stride);
  } else {
    b.jacobians = in.numbers("jacobians", {count, m, n}, false);
    b.twist = in.rows("twist", count, m, b.twist_stride);
  }
  set_bounds(b, in, count, n);
  b.reference = in.rows("reference", count, n, b.reference_stride);
  b.last = in.numbers("last", {count, n}, false);
  if (b.last) {
    b.position_lower = in.rows("position_lower", count, n, ignored);
    b.position_upper = in.rows("position_upper", count, n, ignored);
    b.acceleration = in.rows("acceleration", count, n, ignored);
    b.period = nb::cast<double>(given["period"]);
  }
  b.rates = out.numbers("rates", {count, n}, true, "out");
  b.status = out.integers<std::int32_t>("status", count, "int32");
  b.residual = out.numbers("residual", {count, m}, true);
  b.damping = out.numbers("damping", {count}, true);
  b.scale = out.numbers("scale", {count}, true);
  b.task_error = out.numbers("task_error", {count}, true);
  b.pose = out.numbers("pose", {count, 4, 4}, true);
  b.jacobian = out.numbers("jacobian", {count, m, n}, true);
  b.active = out.integers<std::int8_t>("active", count * n, "int8");
  b.iterations = out.integers<std::int32_t>("iterations", count, "int32");
  const bool full = b.metric.joints != nullptr;
  run_unlocked(count, rows_at_once(n, full), threads > 0 ? threads : default_threads(),
               [&](std::ptrdiff_t first, std::ptrdiff_t last, const Stopped&) {
                 Lease<BatchScratch> scratch(batch_scratch());
                 kernel().batch(b, first, last, scratch->fit(b.arm.n, full));
               });
}

// Many scenarios advanced together; `given` and `answers` by name as below.
void rollout_batch(const Law& law, const Metric& metric, const Arm& arm, nb::sequence rows, bool tool_axes, long count,
                   long steps, long every, double period, bool runge_kutta, std::pair<long, long> twist_strides,
                   nb::dict given, nb::dict answers, int threads) {
  stillreach::BatchRollout r{};
  stillreach::Batch& b = r.batch;
  const long n = metric.data->n, records = (steps + every - 1) / every;
  Arrays in(given), out(answers);
  set_task(b, law, metric, rows, tool_axes);
  if (arm.n() != n) refuse("arm", std::to_string(arm.n()) + " joints", std::to_string(n) + ", as the metric has");
  b.arm = arm.view();
  set_bounds(b, in, count, n);
  r.start = in.numbers("start", {count, n}, false);
  r.last = in.numbers("last_rates", {count, n}, false);
  r.twist_row = twist_strides.first;
  r.twist_step = twist_strides.second;
  r.twist = in.numbers("twist", {(r.twist_row ? count : 1) * (r.twist_step ? steps : 1) * 6}, false);
  if ((r.twist_row != 0 && r.twist_row != (r.twist_step ? 6 * steps : 6)) || (r.twist_step != 0 && r.twist_step != 6))
    refuse("twist_strides", "others", "those of the array");
  std::ptrdiff_t ignored;
  b.position_lower = in.rows("position_lower", count, n, ignored);
  b.position_upper = in.rows("position_upper", count, n, ignored);
  b.acceleration = in.rows("acceleration", count, n, ignored);
  b.period = r.period = period;
  r.steps = steps;
  r.every = every;
  r.runge_kutta = runge_kutta;
  r.q = out.numbers("q", {count, records, n}, true);
  r.rates = out.numbers("rates", {count, records, n}, true);
  r.task_error = out.numbers("task_error", {count, records}, true);
  r.status = out.integers<std::int32_t>("status", count * records, "int32");
  r.final_q = out.numbers("final_q", {count, n}, true);
  r.final_rates = out.numbers("final_rates", {count, n}, true);
  r.worst_error = out.numbers("worst_error", {count}, true);
  r.any_status = out.integers<std::int32_t>("any_status", count, "int32");
  const bool full = b.metric.joints != nullptr;
  const std::ptrdiff_t block = std::min<std::ptrdiff_t>(rows_at_once(n, full), stillreach::kRolloutBlock);
  run_unlocked(count, block, threads > 0 ? threads : default_threads(),
               [&](std::ptrdiff_t first, std::ptrdiff_t last, const Stopped& stopped) {
                 Lease<BatchScratch> scratch(batch_scratch());
                 stillreach::BatchRollout mine = r;
                 mine.stop = [](void* context) { return (*static_cast<const Stopped*>(context))(); };
                 mine.context = const_cast<Stopped*>(&stopped);
                 kernel().rollout_rows(mine, first, last, scratch->fit(b.arm.n, full),
                                       scratch->fit_more(kernel().rollout_doubles(b.arm.n)));
               });
}

}  // namespace

void bind_batch(nb::module_& m) {
  m.def("solve_batch", &solve_batch, nb::arg("law"), nb::arg("metric"), nb::arg("arm").none(), nb::arg("rows"),
        nb::arg("tool_axes"), nb::arg("count"), nb::arg("given"), nb::arg("answers"), nb::arg("threads"),
        "Answers `count` rows. given: q (N, n) and twist (N, 6) or (6,) with an arm, or jacobians (N, m, n) and twist "
        "(N, m) or "
        "(m,); lower and upper (N, n) or (n,); reference likewise; last (N, n) with period, position_lower, "
        "position_upper and "
        "acceleration (n,). answers: arrays to fill, by name. threads: 0 for the default.");
  m.def("rollout_batch", &rollout_batch, nb::arg("law"), nb::arg("metric"), nb::arg("arm"), nb::arg("rows"),
        nb::arg("tool_axes"), nb::arg("count"), nb::arg("steps"), nb::arg("every"), nb::arg("period"),
        nb::arg("runge_kutta"), nb::arg("twist_strides"), nb::arg("given"), nb::arg("answers"), nb::arg("threads"),
        "Advances `count` rows by `steps`. given: start (N, n), twist (flat, with twist_strides per row and step, 0 "
        "where shared), "
        "lower and upper (N, n) or (n,), last_rates (N, n), position_lower, position_upper and acceleration (n,). "
        "answers: arrays to "
        "fill, by name: q, rates (N, R, n), task_error, status (N, R) with R = ceil(steps / every); final_q, "
        "final_rates (N, n), "
        "worst_error, any_status (N,).");
  m.def("default_threads", &default_threads, "Threads that a batch uses where nothing says how many.");
}
