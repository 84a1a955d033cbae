#include "controller.hpp"

#include "stillreach/control/setup.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

void Controller::take_next() {
  const std::unique_ptr<NullMotion> taken = std::move(next);
  stillreach::Settings& s = settings();
  std::copy_n(taken->vector.data(), n(), core.writable(s.null_vector));
  s.null_kind = taken->kind;
  s.null_gain = taken->gain;
  s.null_largest = taken->largest;
  s.null_failures = taken->failures;
  std::swap(gradient, taken->gradient);  // the old one ends with `taken`, and may run Python code then
}

bool Controller::update_gradient(const double* q, bool raise) {
  const nb::object called = gradient;
  Lease<std::vector<double>> read(proposed);
  read->assign(to_size(n()), 0.0);
  bool fine = true;
  try {
    nb::object at = new_vector(n());
    View view;
    view.open(at);
    std::copy_n(q, n(), view.data());
    read_vector("gradient(q)", called(at), n(), read->data(), true, labels);
  } catch (nb::python_error& error) {
    if (raise || !error.matches(PyExc_Exception) || error.matches(PyExc_KeyboardInterrupt)) throw;
    error.discard_as_unraisable("stillreach: the null motion's gradient");
    read->assign(to_size(n()), 0.0);
    fine = false;
  }
  // A tick inside the gradient may have brought another null motion, whose numbers these are not.
  if (gradient.is(called)) std::copy_n(read->data(), n(), core.writable(settings().null_vector));
  return fine;
}

static void make_controller(Controller* self, const Arm& arm, const Law& law, const Metric& metric, nb::sequence rows,
                            bool tool_axes, double period, nb::handle rotary, nb::handle labels, double return_rate,
                            double transition_rate, double track_gain, nb::handle track_limits) {
  const int m = static_cast<int>(nb::len(rows));
  stillreach::Settings s{};
  s.arm = arm.view();
  s.law = law.settings;
  s.metric = metric.data->view();
  s.m = m;
  s.every_row = m == 6 && !tool_axes;
  s.tool_axes = tool_axes;
  for (int r = 0; r < m; ++r) {
    s.rows[r] = nb::cast<int>(rows[r]);
    s.every_row = s.every_row && s.rows[r] == r;
  }
  s.period = period;
  s.return_rate = return_rate;
  s.transition_rate = transition_rate;
  s.track_gain = track_gain;
  s.track_automatic = track_limits.is_none();
  if (!s.track_automatic) {
    s.track_linear = nb::cast<double>(track_limits[0]);
    s.track_angular = nb::cast<double>(track_limits[1]);
  }
  s.null_kind = stillreach::NullMotionKind::NONE;
  s.null_largest = std::numeric_limits<double>::infinity();
  std::vector<std::int8_t> turns;
  for (int i = 0; i < arm.n(); ++i) turns.push_back(nb::cast<bool>(rotary[i]));
  Controller& c = *new (self) Controller(arm, metric.data, s, labels);
  std::copy_n(turns.data(), arm.n(), c.core.writable(c.settings().rotary));
}

// closing: the Closing bits of what closes in within the acceleration limits.
static void set_limits(Controller& c, nb::handle rate_lower, nb::handle rate_upper, nb::handle position_lower,
                       nb::handle position_upper, nb::handle acceleration, double speed, int closing) {
  stillreach::Settings& s = c.settings();
  const auto copy = [&](nb::handle from, const double* to) {
    read_vector("limits", from, c.n(), c.core.writable(to), false);
  };
  copy(rate_lower, s.rate_lower);
  copy(rate_upper, s.rate_upper);
  copy(acceleration, s.acceleration);
  copy(position_lower, s.position_lower);
  copy(position_upper, s.position_upper);
  s.speed = speed;
  c.core.limits_changed(closing);
}

// What is broken and what the last tick left, for a copy of the controller.
static nb::bytes get_state(Controller& c) {
  std::string all;
  const auto add = [&](const auto* from, int count) {
    all.append(reinterpret_cast<const char*>(from), sizeof *from * to_size(count));
  };
  stillreach::each_memory(c.core.state, add);
  return nb::bytes(all.data(), all.size());
}

static void set_state(Controller& c, nb::bytes state) {
  std::size_t wanted = 0;
  stillreach::each_memory(c.core.state, [&](auto* to, int count) { wanted += sizeof *to * to_size(count); });
  if (state.size() != wanted)
    refuse("state", std::to_string(state.size()) + " bytes", std::to_string(wanted) + " bytes");
  const char* at = static_cast<const char*>(state.data());
  const auto take = [&](auto* to, int count) {
    std::memcpy(to, at, sizeof *to * to_size(count));
    at += sizeof *to * to_size(count);
  };
  stillreach::each_memory(c.core.state, take);
  c.core.state.last.bounds_stand = 0;
  kernel().bound_correction(c.core.state);
}

// Everything that the controller was told, as numbers in a row: the head, then the settings.
static nb::bytes get_setup(Controller& c) {
  if (c.next) c.take_next();
  const stillreach::SetupHead head = stillreach::head_of(c.settings());
  std::vector<double> all;
  for (int size :
       {head.n, head.moved, head.coupled, head.m, head.has_rows, head.has_units, head.has_columns, head.full})
    all.push_back(size);
  stillreach::each_setting(c.settings(), [&all](const auto& value) { all.push_back(static_cast<double>(value)); });
  return nb::bytes(all.data(), all.size() * sizeof(double));
}

// Runs a tick and takes what it answers. All memory is found before the tick, so that it runs whole or not at all.
static Solution solution_of_tick(Controller& c, const double* q, const double* twist, const double* target,
                                 double period, nb::handle out) {
  const stillreach::ControllerState& state = c.core.state;
  const stillreach::Answer& answer = c.core.answer;
  const int n = c.n(), m = state.settings.m;
  Solution s;
  s.metric = c.metric;
  s.m = m;
  s.n = n;
  s.rank_tolerance = state.settings.law.rank_tolerance;
  s.make_room();
  s.rates = out.is_none() ? new_vector(n) : nb::borrow(out);
  View view;
  double* to = numpy_vector(s.rates, n, true);
  if (!to) {
    view = strict("out", s.rates, {n}, true);
    to = view.data();
  }
  c.run(q, twist, target, period);
  const stillreach::RateBounds& bounds = state.now.bounds;
  std::copy_n(answer.rates, n, to);
  std::copy_n(stillreach::task_jacobian(state.settings, state.now), m * n, s.jacobian());
  std::copy_n(bounds.lower, n, s.lower());
  std::copy_n(bounds.upper, n, s.upper());
  std::copy_n(state.now.twist, m, s.twist());
  std::copy_n(answer.residual, m, s.residual());
  std::int8_t* const reasons = s.reasons();
  for (int i = 0; i < n; ++i)
    reasons[i] = stillreach::active_reason(answer.active[i], bounds.lower_reason[i], bounds.upper_reason[i]);
  s.status = answer.status;
  s.iterations = answer.iterations;
  s.damping = answer.damping;
  s.scale = answer.scale;
  s.task_error = answer.task_error;
  s.set_multiplier(state.last.multiplier);
  return s;
}

// [s] of this tick, 0 for the controller's own.
static double read_period(nb::handle period) {
  if (period.is_none()) return 0.0;
  return nb::cast<double>(nb::module_::import_("stillreach._door").attr("positive")("period", period));
}

// Names of the rows of a twist.
static nb::handle twist_labels() {
  static PyObject* const labels = nb::object(nb::module_::import_("stillreach._door").attr("TWIST")).release().ptr();
  return labels;
}

static Solution step(Controller& c, nb::handle q, nb::handle twist, nb::handle period, nb::handle out) {
  Lease<std::vector<double>> at(c.measured);
  at->resize(to_size(c.n()));
  double command[6];
  read_vector("q", q, c.n(), at->data(), true, c.labels);
  read_vector("twist", twist, 6, command, true, twist_labels());
  const double held = read_period(period);
  c.prepare(at->data(), true);
  return solution_of_tick(c, at->data(), command, nullptr, held, out);
}

void read_target(const char* argument, nb::handle pose, double* to) {
  View matrix;
  nb::object converted;
  if (!(matrix.open(pose) && matrix.is_double() && matrix.is_contiguous() && matrix.ndim() == 2 &&
        matrix.size(0) == 4 && matrix.size(1) == 4)) {
    converted = nb::module_::import_("stillreach._door").attr("pose")(argument, pose);
    matrix = strict(argument, converted, {4, 4}, false);
  }
  if (!kernel().read_pose(matrix.data(), to)) {
    nb::module_::import_("stillreach._door").attr("pose")(argument, pose);
    refuse(argument, describe(pose), "a rigid transform (4 x 4)");
  }
}

static Solution track(Controller& c, nb::handle q, nb::handle target_pose, nb::handle feedforward, nb::handle period,
                      nb::handle out) {
  Lease<std::vector<double>> at(c.measured);
  at->resize(to_size(c.n()));
  double command[6] = {0, 0, 0, 0, 0, 0}, target[12];
  read_vector("q", q, c.n(), at->data(), true, c.labels);
  read_target("target_pose", target_pose, target);
  if (!feedforward.is_none()) read_vector("feedforward", feedforward, 6, command, true, twist_labels());
  const double held = read_period(period);
  c.prepare(at->data(), true);
  return solution_of_tick(c, at->data(), command, target, held, out);
}

// The garbage collector's view of what a controller owns.
static int visit_controller(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  const Controller& c = *nb::inst_ptr<Controller>(self);
  Py_VISIT(c.gradient.ptr());
  if (c.next) Py_VISIT(c.next->gradient.ptr());
  return 0;
}

static int clear_controller(PyObject* self) {
  if (!nb::inst_ready(self)) return 0;
  Controller& c = *nb::inst_ptr<Controller>(self);
  const nb::object gradient = std::move(c.gradient);
  const std::unique_ptr<NullMotion> next = std::move(c.next);
  return 0;
}

static PyType_Slot controller_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_controller)},
                                         {Py_tp_clear, reinterpret_cast<void*>(&clear_controller)},
                                         {0, nullptr}};
static void set_fault(Controller& c, int joint, stillreach::Health health, double first, double second) {
  c.core.set_fault(joint, {health, {first, second}});
}

static void reset(Controller& c, nb::handle rates) {
  if (rates.is_none()) return c.core.reset();
  std::vector<double> read(to_size(c.n()));
  read_vector("rates", rates, c.n(), read.data(), true, c.labels);
  c.core.reset(read.data());
}

static void set_null_motion(Controller& c, stillreach::NullMotionKind kind, double gain, double largest,
                            nb::handle vector, nb::handle gradient, int failures) {
  auto next = std::make_unique<NullMotion>();
  next->kind = kind;
  next->gain = gain;
  next->largest = largest;
  next->failures = failures;
  next->vector.assign(to_size(c.n()), 0.0);
  if (!vector.is_none()) read_vector("null_motion", vector, c.n(), next->vector.data());
  if (!gradient.is_none()) next->gradient = nb::borrow(gradient);
  std::swap(c.next, next);
}

void bind_controller(nb::module_& m) {
  nb::class_<Controller> c(m, "ControllerCore", nb::type_slots(controller_slots),
                           "The compiled part of stillreach.Controller.");
  c.def("__init__", &make_controller, nb::kw_only(), nb::arg("arm"), nb::arg("law"), nb::arg("metric"), nb::arg("rows"),
        nb::arg("tool_axes"), nb::arg("period"), nb::arg("rotary"), nb::arg("labels"), nb::arg("return_rate"),
        nb::arg("transition_rate"), nb::arg("track_gain"), nb::arg("track_limits").none());
  c.def("step", &step, nb::arg("q").none(), nb::arg("twist").none(), nb::kw_only(),
        nb::arg("period").none() = nb::none(), nb::arg("out").none() = nb::none(),
        nb::sig("def step(self, q: numpy.typing.ArrayLike | collections.abc.Mapping[str, float], twist: "
                "numpy.typing.ArrayLike | "
                "collections.abc.Mapping[str, float], *, period: float | None = None, out: "
                "numpy.typing.NDArray[numpy.float64] | None = "
                "None) -> Solution"),
        "One tick: q (n,) [rad, m] measured, twist (6,) [m/s, rad/s] commanded along base axes -> Solution.\n\n"
        "q may be a mapping or a pandas Series by joint name. period [s] is how long these rates are held, where that "
        "differs from tick "
        "to tick; None: the controller's. out (n,) receives the rates instead of a new array. Raises InputError for "
        "anything that is not "
        "finite or not of the right shape; the controller is then as it was.");
  c.def("track", &track, nb::arg("q").none(), nb::arg("target_pose").none(), nb::arg("feedforward").none() = nb::none(),
        nb::kw_only(), nb::arg("period").none() = nb::none(), nb::arg("out").none() = nb::none(),
        nb::sig("def track(self, q: numpy.typing.ArrayLike | collections.abc.Mapping[str, float], target_pose: "
                "numpy.typing.ArrayLike, "
                "feedforward: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None, *, period: "
                "float | None = None, "
                "out: numpy.typing.NDArray[numpy.float64] | None = None) -> Solution"),
        "One tick that closes the loop on the tool's pose: target_pose (4, 4) [m] in the base frame, feedforward (6,) "
        "the twist "
        "that the target moves with -> Solution.\n\n"
        "A target within 1e-5 of a rigid transform (float32, six decimals) is brought to the nearest one. q, period "
        "and out: as of step.");
  c.def("_set_fault", &set_fault, nb::arg("joint"), nb::arg("health"), nb::arg("first"), nb::arg("second"));
  c.def("_set_limits", &set_limits, nb::arg("rate_lower"), nb::arg("rate_upper"), nb::arg("position_lower"),
        nb::arg("position_upper"), nb::arg("acceleration"), nb::arg("speed"), nb::arg("closing"));
  c.def("_get_state", &get_state);
  c.def("_get_setup", &get_setup);
  c.def("_set_state", &set_state, nb::arg("state"));
  c.def("_reset", &reset, nb::arg("rates").none());
  c.def("_set_null_motion", &set_null_motion, nb::arg("kind"), nb::arg("gain"), nb::arg("largest"),
        nb::arg("vector").none(), nb::arg("gradient").none(), nb::arg("failures"));
  c.def_prop_ro(
      "health",
      [](const Controller& s) {
        nb::object numpy = nb::module_::import_("numpy");
        std::string codes;
        for (int i = 0; i < s.n(); ++i) codes.push_back(static_cast<char>(s.core.state.faults.of[i].health));
        return numpy.attr("frombuffer")(nb::bytes(codes.data(), codes.size()), nb::arg("dtype") = numpy.attr("int8"));
      },
      nb::sig("def health(self) -> numpy.typing.NDArray[numpy.int8]"), "(n,) Health of each joint.");
  c.def_prop_ro(
      "last_rates",
      [](const Controller& s) {
        nb::object array = new_vector(s.n());
        View view;
        view.open(array);
        std::copy_n(s.core.state.last.rates, s.n(), view.data());
        return array;
      },
      nb::sig("def last_rates(self) -> numpy.typing.NDArray[numpy.float64]"), "(n,) the last commanded rates.");
  bind_bound_tick(m, c);
  bind_rollout(m, c);
}
