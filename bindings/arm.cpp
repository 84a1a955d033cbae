#include <algorithm>
#include <cstring>

#include "settings.hpp"

// Whom each of `moved` joints of the chain follows.
static std::vector<int> read_leaders(nb::handle given, int moved) {
  std::vector<int> leaders;
  for (nb::handle leader : nb::iter(given)) {
    leaders.push_back(nb::cast<int>(nb::int_(leader)));
    if (leaders.back() < 0 || leaders.back() >= moved) refuse("leaders", describe(given), "indices of joints");
  }
  if (static_cast<int>(leaders.size()) != moved) refuse("leaders", describe(given), std::to_string(moved) + " of them");
  return leaders;
}

static void make_arm(Arm* self, nb::handle kinds, nb::handle placements, nb::handle axes, nb::handle tool,
                     nb::handle leaders, nb::handle factors, nb::handle offsets) {
  View poses, directions, end = strict("tool", tool, {4, 4}, false);
  const long n = poses.open(placements) && poses.ndim() == 3 ? poses.size(0) : -1;
  View checked = strict("placements", placements, {n < 1 ? 1 : n, 4, 4}, false);
  View axis = strict("axes", axes, {n, 3}, false);
  std::vector<double> all(16 * to_size(n + 1));
  std::copy_n(checked.data(), 16 * n, all.data());
  std::copy_n(end.data(), 16, all.data() + 16 * n);
  std::vector<stillreach::JointKind> kind;
  for (nb::handle k : nb::iter(kinds)) kind.push_back(nb::cast<stillreach::JointKind>(k));
  if (static_cast<long>(kind.size()) != n) refuse("kinds", describe(kinds), std::to_string(n) + " kinds");
  std::vector<int> follows;
  std::vector<double> times, plus;
  if (!leaders.is_none()) {
    const int moved = static_cast<int>(n);
    follows = read_leaders(leaders, moved);
    times.resize(to_size(n));
    plus.resize(to_size(n));
    read_vector("factors", factors, moved, times.data());
    read_vector("offsets", offsets, moved, plus.data());
  }
  new (self) Arm(kind, all.data(), axis.data(), std::move(follows), std::move(times), std::move(plus));
}

constexpr long kRowsAtOnce = 64;
constexpr long kRowsAlone = 512;  // fewer are not worth waking a thread

// All rows of b, without the interpreter's lock, on several threads where there are many; Ctrl-C ends it.
static void each_row(const stillreach::KinematicsBatch& b, long count) {
  const std::size_t wanted = kernel().kinematics_doubles(b.arm.n, b.count, b.metric.joints != nullptr);
  const auto work = [&](std::ptrdiff_t first, std::ptrdiff_t last, const Stopped&) {
    static thread_local std::vector<double> kept;
    Lease<std::vector<double>> scratch(kept);
    kernel().kinematics_rows(b, first, last, aligned(*scratch, wanted));
  };
  if (count <= kRowsAtOnce) return work(0, count, {});
  run_unlocked(count, kRowsAtOnce, count > kRowsAlone ? default_threads() : 1, work);
}

// Poses (N, 4, 4) or Jacobians (N, 6, n) at each row of q (N, n).
static nb::object kinematics(const Arm& arm, nb::handle q, bool want_jacobian) {
  View rows = strict("q", q, {-1, arm.n()}, false);
  const long count = rows.size(0), n = arm.n();
  nb::object out =
      new_array(want_jacobian ? nb::object(nb::make_tuple(count, 6, n)) : nb::object(nb::make_tuple(count, 4, 4)));
  View to = strict("out", out, {count, want_jacobian ? 6 : 4, want_jacobian ? n : 4}, true);
  stillreach::KinematicsBatch b{};
  b.arm = arm.view();
  b.q = rows.data();
  (want_jacobian ? b.jacobian : b.pose) = to.data();
  each_row(b, count);
  return out;
}

// Singular values (N, min(m, joints)) of the task's weighted Jacobian at each row of q, or their products (N,).
static nb::object spectra(const Arm& arm, nb::handle q, const Metric& metric, nb::sequence task_rows, bool tool_axes,
                          nb::sequence joints, bool product) {
  View rows = strict("q", q, {-1, arm.n()}, false);
  const long count = rows.size(0);
  stillreach::KinematicsBatch b{};
  b.arm = arm.view();
  b.q = rows.data();
  b.metric = metric.data->view();
  b.m = metric.data->m;
  b.tool_axes = tool_axes;
  int r = 0;
  for (nb::handle row : task_rows)
    if (r < 6) b.rows[r++] = nb::cast<int>(row);
  std::vector<int> chosen;
  for (nb::handle joint : joints) chosen.push_back(nb::cast<int>(joint));
  if (r != b.m || metric.data->n != arm.n())
    refuse("metric", std::to_string(metric.data->n) + " joints", std::to_string(arm.n()));
  b.joints = chosen.data();
  b.count = static_cast<int>(chosen.size());
  nb::object out = new_array(product ? nb::object(nb::make_tuple(count))
                                     : nb::object(nb::make_tuple(count, std::min(b.m, b.count))));
  View to;
  to.open(out);
  (product ? b.manipulability : b.singular_values) = to.data();
  each_row(b, count);
  return out;
}

void bind_arm(nb::module_& m) {
  nb::class_<Arm>(m, "ArmModel", "A serial chain, as the core reads it.")
      .def("__init__", &make_arm, nb::arg("kinds"), nb::arg("placements"), nb::arg("axes"), nb::arg("tool"),
           nb::arg("leaders") = nb::none(), nb::arg("factors") = nb::none(), nb::arg("offsets") = nb::none(),
           "kinds (n,) JointKind; placements (n, 4, 4) of the joint frames seen from what the joint before moves; "
           "axes (n, 3) unit vectors in the joint frames; tool (4, 4). With leaders (n,) of these joints joint a is at "
           "factors[a] q[leaders[a]] + offsets[a], and the arm has as many joints as there are leaders.")
      .def_prop_ro(
          "n", [](const Arm& a) { return a.n(); }, "Number of joints.")
      .def(
          "forward", [](const Arm& a, nb::handle q) { return kinematics(a, q, false); }, nb::arg("q"),
          nb::sig("def forward(self, q: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"),
          "q (N, n) [rad, m] -> (N, 4, 4) [m] pose of the tool seen from the base.")
      .def(
          "jacobian", [](const Arm& a, nb::handle q) { return kinematics(a, q, true); }, nb::arg("q"),
          nb::sig("def jacobian(self, q: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"),
          "q (N, n) [rad, m] -> (N, 6, n): [v; w] of the tool point, base axes.")
      .def("spectra", &spectra, nb::arg("q"), nb::arg("metric"), nb::arg("rows"), nb::arg("tool_axes"),
           nb::arg("joints"), nb::arg("product"),
           nb::sig("def spectra(self, q: numpy.typing.NDArray[numpy.float64], metric: Metric, rows: "
                   "collections.abc.Sequence[int], "
                   "tool_axes: bool, joints: collections.abc.Sequence[int], product: bool) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "q (N, n) [rad, m] -> (N, min(m, joints)) singular values, falling, of these columns of the task's weighted "
           "Jacobian; "
           "or (N,) their product, 0 where there are fewer columns than rows.");
}
