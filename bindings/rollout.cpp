// Chunks of simulated ticks.
#include "controller.hpp"

// An array of the record, to be written in place.
template <class T>
static View open_array(const char* name, nb::handle array, long count) {
  View view;
  const bool fits = view.open(array) && view.is_contiguous() && view.is_writable() && view.is_aligned(alignof(T)) &&
                    view.is_double() == std::is_same_v<T, double>;
  if (!fits || view.bytes() != static_cast<long>(sizeof(T)) * count)
    refuse(name, describe(array),
           "a writable C-contiguous array of " + std::to_string(count) + " values of " + std::to_string(sizeof(T)) +
               " bytes");
  return view;
}

// The plant of a simulation: its state, from chunk to chunk.
struct SimulatedPlant {
  std::vector<stillreach::Fault> faults;
  std::vector<double> actual, told, seen;
  stillreach::Plant plant{};
  SimulatedPlant(int n, double follow, long dead, double resolution)
      : faults(to_size(n)), actual(to_size(n)), told(to_size(dead * n)), seen(to_size(n)) {
    plant = {faults.data(), follow, actual.data(), dead, told.data(), 0, resolution, nullptr, seen.data()};
  }
  SimulatedPlant(const SimulatedPlant& other)
      : faults(other.faults), actual(other.actual), told(other.told), seen(other.seen), plant(other.plant) {
    plant.faults = faults.data();
    plant.actual = actual.data();
    plant.told = told.data();
    plant.seen = seen.data();
  }
  SimulatedPlant& operator=(const SimulatedPlant&) = delete;
};

static void rollout(Controller& c, nb::handle q, nb::handle twists, nb::handle targets, nb::str integrator,
                    bool advance, SimulatedPlant* plant, nb::handle noise, nb::dict record) {
  const long n = c.n();
  const std::string method = integrator.c_str();
  if (method != "euler" && method != "rk4") refuse("integrator", "'" + method + "'", "'euler' or 'rk4'");
  const int stages = method == "rk4" ? 2 : 1;
  View at = strict("q", q, {n}, true), commands = strict("twists", twists, {-1, 6}, false);
  const long rows = commands.size(0), steps = stages == 2 && advance ? (rows - 1) / 2 : rows;
  if (stages == 2 && advance && rows % 2 != 1)
    refuse("twists", std::to_string(rows) + " rows", "2 K + 1 rows: one each half tick");
  View poses;
  const double* frames = nullptr;
  if (!targets.is_none()) {
    poses = strict("targets", targets, {rows, 12}, false);
    frames = poses.data();
  }
  if (plant && static_cast<long>(plant->faults.size()) != n) refuse("plant", "a plant of another arm", "this arm's");
  View errors;
  if (!noise.is_none()) errors = strict("noise", noise, {steps, n}, false);
  std::vector<View> open;
  stillreach::Record to{};
  stillreach::each_array(to, static_cast<int>(n), [&](auto*& array, const char* name, int count) {
    using Value = std::remove_reference_t<decltype(*array)>;
    if (!record.contains(name)) return;
    open.push_back(open_array<Value>(name, record[name], steps * count));
    array = static_cast<Value*>(static_cast<void*>(open.back().data()));
  });
  std::vector<double> scratch(4 * to_size(n));
  std::vector<std::int8_t> scratch_active(to_size(n));
  const auto run = [&](long first, long count, const stillreach::Record& where) {
    if (plant) plant->plant.noise = noise.is_none() ? nullptr : errors.data() + n * first;
    kernel().rollout(c.core.state, at.data(), commands.data() + 6 * stages * first,
                     frames ? frames + 12 * stages * first : nullptr, count, stages, advance,
                     plant ? &plant->plant : nullptr, c.core.workspace.view(), c.core.answer, scratch.data(),
                     scratch_active.data(), where);
  };
  c.prepare(at.data(), true);
  if (!c.gradient.is_valid()) {
    nb::gil_scoped_release others_may_run;
    return run(0, steps, to);
  }
  for (long t = 0; t < steps; ++t) {  // the user's gradient is Python's to evaluate, once a tick
    if (t > 0) c.prepare(at.data(), true);
    stillreach::Record row = to;
    stillreach::each_array(row, static_cast<int>(n), [t](auto*& array, const char*, int count) {
      if (array) array += t * count;
    });
    run(t, 1, row);
  }
}

// Poses as the core reads them, 12 numbers each.
static nb::object frames(nb::handle poses) {
  View T = strict("poses", poses, {-1, 4, 4}, false);
  const long rows = T.size(0);
  nb::object array = new_array(nb::make_tuple(rows, 12));
  double* to = strict("frames", array, {rows, 12}, true).data();
  for (long t = 0; t < rows; ++t)
    if (!kernel().read_pose(T.data() + 16 * t, to + 12 * t))
      refuse("poses", "row " + std::to_string(t), "rigid transforms (4 x 4)");
  return array;
}

static nb::object pose_distances(nb::handle actual, nb::handle wanted, nb::handle asked, bool along_pose) {
  View from = strict("actual", actual, {-1, 4, 4}, false);
  const long rows = from.size(0);
  View to = strict("wanted", wanted, {rows, 4, 4}, false), mask = strict("asked", asked, {6}, false);
  nb::object array = new_array(nb::make_tuple(2, rows));
  double* off = strict("off", array, {2, rows}, true).data();
  nb::gil_scoped_release others_may_run;
  kernel().pose_distances(from.data(), to.data(), rows, mask.data(), along_pose, off);
  return array;
}

void bind_rollout(nb::module_& m, nb::class_<Controller>& c) {
  m.attr("RIGID_TOLERANCE") = stillreach::kRigid;
  nb::list names;
  stillreach::Record record{};
  stillreach::each_array(record, 1, [&names](auto*&, const char* name, int) { names.append(name); });
  m.attr("RECORDED") = nb::tuple(names);
  m.def(
      "rigid",
      [](nb::handle T) -> nb::object {
        double pose[12];
        if (!kernel().read_pose(strict("T", T, {4, 4}, false).data(), pose)) return nb::none();
        nb::object rigid = new_array(nb::make_tuple(4, 4));
        stillreach::write_pose(pose, strict("T", rigid, {4, 4}, true).data());
        return rigid;
      },
      nb::arg("T"),
      nb::sig("def rigid(T: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64] | None"),
      "The rigid transform nearest to T (4, 4), or None where none is within RIGID_TOLERANCE.");
  m.def("frames", &frames, nb::arg("poses"),
        nb::sig("def frames(poses: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]"),
        "Poses (K, 4, 4) as a rollout reads its targets, (K, 12).");
  m.def("pose_distances", &pose_distances, nb::arg("actual"), nb::arg("wanted"), nb::arg("asked"),
        nb::arg("along_pose"),
        nb::sig("def pose_distances(actual: numpy.typing.NDArray[numpy.float64], wanted: "
                "numpy.typing.NDArray[numpy.float64], asked: numpy.typing.NDArray[numpy.float64], along_pose: bool) -> "
                "numpy.typing.NDArray[numpy.float64]"),
        "(2, K) distances [m] and angles [rad] of poses (K, 4, 4) from those that are wanted.\n\n"
        "asked (6,): 1 for each component of the twist between them that counts; along_pose: these are along the axes "
        "of the actual pose, not of the base. NaN where a matrix is no pose.");
  nb::class_<SimulatedPlant>(m, "SimulatedPlant", "An arm with its true faults, late drives and encoders.")
      .def(nb::init<int, double, long, double>(), nb::arg("n"), nb::kw_only(), nb::arg("follow"), nb::arg("dead"),
           nb::arg("resolution"))
      .def(
          "set_fault",
          [](SimulatedPlant& p, int joint, stillreach::Health health, double first, double second) {
            if (joint < 0 || to_size(joint) >= p.faults.size()) refuse("joint", std::to_string(joint), "a joint");
            p.faults[to_size(joint)] = {health, {first, second}};
          },
          nb::arg("joint"), nb::arg("health"), nb::arg("first"), nb::arg("second"))
      .def("copy", [](const SimulatedPlant& p) { return SimulatedPlant(p); }, "A plant in the same state.");
  c.def(
      "rollout", &rollout, nb::arg("q"), nb::arg("twists"), nb::arg("targets").none() = nb::none(), nb::kw_only(),
      nb::arg("integrator") = "euler", nb::arg("advance") = true, nb::arg("plant").none() = nb::none(),
      nb::arg("noise").none() = nb::none(), nb::arg("record"),
      "A chunk of simulated ticks from q (n,), which is moved along.\n\n"
      "twists (K, 6) commands, for \"rk4\" (2 K + 1, 6), one each half tick; targets (as many, 12) poses to track, of "
      "frames(), "
      "or None; "
      "plant: what the arm makes of the rates, or None; noise (K, n) of its encoders, or None. "
      "record: arrays by the names of Run, K rows each, those that are wanted; advance=False records K ticks at q and "
      "leaves it where it is.");
}
