#include <algorithm>
#include <cstring>

#include "settings.hpp"

// Whom each of the chain's joints follows; without followers each follows itself, and nothing is kept.
static void couple(Arm& arm, nb::handle leaders, nb::handle factors, nb::handle offsets) {
  if (leaders.is_none()) return;
  const int moved = arm.n;
  arm.n = 0;
  for (nb::handle leader : nb::iter(leaders)) {
    arm.leaders.push_back(nb::cast<int>(nb::int_(leader)));
    if (arm.leaders.back() < 0 || arm.leaders.back() >= moved) refuse("leaders", describe(leaders), "indices of joints");
    arm.n = std::max(arm.n, arm.leaders.back() + 1);
  }
  arm.factors.resize(moved), arm.offsets.resize(moved);
  read_vector("factors", factors, moved, arm.factors.data());
  read_vector("offsets", offsets, moved, arm.offsets.data());
  if (static_cast<int>(arm.leaders.size()) != moved) refuse("leaders", describe(leaders), std::to_string(moved) + " of them");
}

static void make_arm(Arm* self, nb::handle kinds, nb::handle placements, nb::handle axes, nb::handle tool, nb::handle leaders,
                     nb::handle factors, nb::handle offsets) {
  View poses, directions, end = strict("tool", tool, {4, 4}, false);
  const long n = poses.open(placements) && poses.ndim() == 3 ? poses.size(0) : -1;
  View checked = strict("placements", placements, {n < 1 ? 1 : n, 4, 4}, false);
  View axis = strict("axes", axes, {n, 3}, false);
  std::vector<double> all(16 * (n + 1));
  std::memcpy(all.data(), checked.data(), sizeof(double) * 16 * n);
  std::memcpy(all.data() + 16 * n, end.data(), sizeof(double) * 16);
  std::vector<std::int8_t> kind;
  for (nb::handle k : nb::iter(kinds)) kind.push_back(static_cast<std::int8_t>(nb::cast<int>(nb::int_(k))));
  if (static_cast<long>(kind.size()) != n) refuse("kinds", describe(kinds), std::to_string(n) + " kinds (0 revolute, 1 prismatic)");
  Arm arm{static_cast<int>(n), std::vector<double>(12 * (n + 1)), std::move(kind), {}, {}, {}, {}};
  kernel().align_axes(arm.n, all.data(), axis.data(), arm.placements.data());
  couple(arm, leaders, factors, offsets);
  new (self) Arm(std::move(arm));
}

// Runs the kinematics on each row of q (N, n); writes poses (N, 4, 4) or Jacobians (N, 6, n).
static nb::object each_row(const Arm& arm, nb::handle q, bool want_jacobian) {
  View rows = strict("q", q, {-1, arm.n}, false);
  const long count = rows.size(0), n = arm.n;
  nb::object out = new_array(want_jacobian ? nb::object(nb::make_tuple(count, 6, n)) : nb::object(nb::make_tuple(count, 4, 4)));
  View to = strict("out", out, {count, want_jacobian ? 6 : 4, want_jacobian ? n : 4}, true);
  std::vector<double> scratch(2 * n), jacobian(6 * n + 2);
  const stillreach::ArmView view = arm.view();
  for (long row = 0; row < count; ++row) {
    double pose[12];
    kernel().kinematics(view, rows.data() + row * n, scratch.data(), pose, want_jacobian ? jacobian.data() : nullptr);
    double* at = to.data() + row * (want_jacobian ? 6 * n : 16);
    if (want_jacobian)
      for (int r = 0; r < 6; ++r)
        for (int i = 0; i < n; ++i) at[r * n + i] = jacobian[6 * i + r];
    else
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) at[4 * r + c] = r < 3 ? pose[3 * c + r] : c == 3 ? 1.0 : 0.0;
  }
  return out;
}

void bind_arm(nb::module_& m) {
  nb::class_<Arm>(m, "ArmModel", "A serial chain, as the core reads it.")
      .def("__init__", &make_arm, nb::arg("kinds"), nb::arg("placements"), nb::arg("axes"), nb::arg("tool"),
           nb::arg("leaders") = nb::none(), nb::arg("factors") = nb::none(), nb::arg("offsets") = nb::none(),
           "kinds (n,) 0 revolute, 1 prismatic; placements (n, 4, 4) of the joint frames seen from what the joint before moves; "
           "axes (n, 3) unit vectors in the joint frames; tool (4, 4). With leaders (n,) of these joints joint a is at "
           "factors[a] q[leaders[a]] + offsets[a], and the arm has as many joints as there are leaders.")
      .def_prop_ro("n", [](const Arm& a) { return a.n; }, "Number of joints.")
      .def("forward", [](const Arm& a, nb::handle q) { return each_row(a, q, false); }, nb::arg("q"),
           nb::sig("def forward(self, q: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"),
           "q (N, n) [rad, m] -> (N, 4, 4) [m] pose of the tool seen from the base.")
      .def("jacobian", [](const Arm& a, nb::handle q) { return each_row(a, q, true); }, nb::arg("q"),
           nb::sig("def jacobian(self, q: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"),
           "q (N, n) [rad, m] -> (N, 6, n): [v; w] of the tool point, base axes.");
}
