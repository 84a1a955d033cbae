// Inverse kinematics of many poses, in parallel, without the interpreter's lock.
#include "batch.hpp"

namespace {

constexpr std::ptrdiff_t kLeastBlock = 2 * stillreach::kInverseSlots, kMostBlock = 4096;

void inverse(const Law& law, const Metric& metric, const Arm& arm, nb::sequence rows, bool tool_axes, long count,
             nb::dict given, nb::dict answers, int threads) {
  stillreach::Inverse v{};
  const long n = metric.data->n;
  Arrays in(given), out(answers);
  set_task(v.batch, law, metric, rows, tool_axes);
  if (arm.n() != n) refuse("arm", std::to_string(arm.n()) + " joints", std::to_string(n) + ", as the metric has");
  v.batch.arm = arm.view();
  const double* poses = in.numbers("poses", {count, 4, 4}, false);
  std::vector<double> targets(12 * to_size(count));
  for (long row = 0; row < count; ++row)
    if (!kernel().read_pose(poses + 16 * row, targets.data() + 12 * row))
      refuse("poses", "row " + std::to_string(row), "rigid transforms (4 x 4) of finite numbers");
  v.target = targets.data();
  v.start = in.rows("start", count, n, v.start_stride);
  v.lower = in.numbers("lower", {n}, false);
  v.upper = in.numbers("upper", {n}, false);
  v.low_start = in.numbers("low_start", {n}, false);
  v.range = in.numbers("range", {n}, false);
  v.step = in.numbers("step", {n}, false);
  v.choices = nb::cast<int>(given["choices"]);
  v.values = in.numbers("values", {v.choices, n}, false);
  v.turns = in.integers<std::int8_t>("turns", n, "int8");
  v.hold = in.integers<stillreach::Hold>("hold", n, "int8");
  v.starts = in.integers<std::int32_t>("starts", count, "int32");
  v.steps = nb::cast<int>(given["steps"]);
  v.solutions = nb::cast<int>(given["solutions"]);
  v.apart = nb::cast<double>(given["apart"]);
  v.tolerance = nb::cast<double>(given["tolerance"]);
  v.nearest = nb::cast<bool>(given["nearest"]);
  v.seed = nb::cast<std::uint64_t>(given["seed"]);
  v.q = out.numbers("q", {count, v.solutions, n}, true);
  v.residual = out.numbers("residual", {count, v.solutions}, true);
  v.found = out.integers<std::int32_t>("found", count, "int32");
  v.used = out.integers<std::int32_t>("used", count, "int32");
  v.taken = out.integers<std::int32_t>("taken", count, "int32");
  const bool full = v.batch.metric.joints != nullptr;
  const int most = threads > 0 ? threads : default_threads();
  run_unlocked(count, std::clamp<std::ptrdiff_t>(count / (4 * most), kLeastBlock, kMostBlock), most,
               [&](std::ptrdiff_t first, std::ptrdiff_t last, const Stopped& stopped) {
                 Lease<BatchScratch> scratch(batch_scratch());
                 stillreach::Inverse mine = v;
                 mine.stop = [](void* context) { return (*static_cast<const Stopped*>(context))(); };
                 mine.context = const_cast<Stopped*>(&stopped);
                 kernel().inverse_rows(mine, first, last, scratch->fit(static_cast<int>(n), full),
                                       scratch->fit_more(kernel().inverse_doubles(static_cast<int>(n))));
               });
}

}  // namespace

void bind_inverse(nb::module_& m) {
  m.def("inverse", &inverse, nb::arg("law"), nb::arg("metric"), nb::arg("arm"), nb::arg("rows"), nb::arg("tool_axes"),
        nb::arg("count"), nb::arg("given"), nb::arg("answers"), nb::arg("threads"),
        "Configurations of `count` poses. given: poses (N, 4, 4); start (N, n) or (n,) or none; lower, upper, "
        "low_start, range, step (n,); turns, hold (n,) int8; values (choices, n) with choices; starts (N,) int32; "
        "steps, solutions, apart, tolerance, nearest, seed. answers: arrays to fill: q (N, S, n), residual (N, S), "
        "found, used, taken (N,) int32.");
}
