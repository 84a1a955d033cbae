// What many configurations keep after each loss of joints, in parallel, without the interpreter's lock.
#include "batch.hpp"

namespace {

constexpr std::ptrdiff_t kRowsAtOnce = 64;

void losses(const Arm& arm, nb::sequence rows, bool tool_axes, bool speeds, int sizes, nb::dict given, nb::dict answers,
            int threads) {
  stillreach::LossBatch b{};
  const long n = arm.n();
  Arrays in(given), out(answers);
  b.arm = arm.view();
  b.tool_axes = tool_axes;
  b.m = 0;
  for (nb::handle row : rows)
    if (b.m < 6) b.rows[b.m++] = nb::cast<int>(row);
  if (sizes < 1 || sizes > std::min<long>(n, stillreach::kMostLosses))
    refuse("sizes", std::to_string(sizes), "1 to the number of joints, at most 32");
  const long count = nb::cast<long>(given["count"]);
  b.sizes = sizes;
  b.q = in.numbers("q", {count, n}, false);
  b.rates = in.numbers("rates", {n}, false);
  b.scales = in.numbers("scales", {b.m}, false);
  b.count = given.contains("set_count") ? nb::cast<long>(given["set_count"]) : 0;
  if (speeds) b.sets = in.integers<std::int32_t>("sets", b.count * sizes, "int32");
  b.whole = out.numbers("whole", {count}, true);
  b.joint = out.numbers("joint", {count, n}, true);
  b.worst = out.numbers("worst", {count, sizes}, true);
  b.which = out.integers<std::int32_t>("which", count * sizes, "int32");
  b.every = out.numbers("every", {count, b.count}, true);
  const std::size_t wanted = kernel().loss_doubles(arm.n(), sizes, b.count);
  run_unlocked(count, kRowsAtOnce, threads > 0 ? threads : default_threads(),
               [&](std::ptrdiff_t first, std::ptrdiff_t last, const Stopped&) {
                 static thread_local std::vector<double> kept;
                 Lease<std::vector<double>> scratch(kept);
                 double* memory = aligned(*scratch, wanted);
                 (speeds ? kernel().guaranteed_rows : kernel().relative_rows)(b, first, last, memory);
               });
}

}  // namespace

void bind_losses(nb::module_& m) {
  m.def("losses", &losses, nb::arg("arm"), nb::arg("rows"), nb::arg("tool_axes"), nb::arg("speeds"), nb::arg("sizes"),
        nb::arg("given"), nb::arg("answers"), nb::arg("threads"),
        "What configurations keep without each set of up to `sizes` joints: relative manipulability or, with speeds, "
        "the guaranteed speed. given: count; q (count, n); rates (n,); with speeds scales (m,), and for `every` sets "
        "(set_count, sizes) int32 and set_count. answers: arrays to fill, or none: whole (count,) with all joints "
        "(speeds); joint (count, n); worst (count, sizes); which (count, sizes) int32 (relative manipulability); every "
        "(count, set_count).");
}
