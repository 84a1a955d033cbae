#include "controller.hpp"

#include "stillreach/control/setup.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

void Controller::take_next() {
  const std::unique_ptr<NullMotion> taken = std::move(next);
  std::copy_n(taken->vector.data(), n(), const_cast<double*>(state.null_vector));
  state.null_kind = taken->kind;
  state.null_gain = taken->gain;
  state.null_largest = taken->largest;
  state.null_failures = taken->failures;
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
  if (gradient.is(called)) std::copy_n(read->data(), n(), const_cast<double*>(state.null_vector));
  return fine;
}

static void make_controller(Controller* self, const Arm& arm, const Law& law, const Metric& metric, nb::sequence rows,
                            bool tool_axes, double period, nb::handle rotary, nb::handle labels, double return_rate,
                            double transition_rate, double track_gain, nb::handle track_limits) {
  new (self) Controller();
  Controller& c = *self;
  c.arm = arm;
  c.metric = metric.data;
  c.labels = nb::borrow(labels);
  const int n = arm.n, m = static_cast<int>(nb::len(rows));
  stillreach::ControllerState& s = c.state;
  s.arm = c.arm.view();
  s.law = law.settings;
  s.metric = c.metric->view();
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

  c.numbers.assign(to_size(stillreach::kStateNumbers * n), 0.0);
  c.bytes.assign(to_size(stillreach::kStateBytes * n), 0);
  std::int8_t* const turns = stillreach::point_into(s, c.numbers.data(), c.bytes.data());
  c.faults.assign(to_size(n), {});
  s.faults = c.faults.data();
  for (int i = 0; i < n; ++i) turns[i] = nb::cast<bool>(rotary[i]);
  s.rotary = turns;
  c.rates.assign(to_size(n), 0.0);
  c.residual.assign(6, 0.0);
  c.active.assign(to_size(n), 0);
  c.answer.rates = c.rates.data();
  c.answer.residual = c.residual.data();
  c.answer.active = c.active.data();
  c.scratch.fit(n, !c.metric->joints.empty());
}

// closing: the Closing bits of what closes in within the acceleration limits.
static void set_limits(Controller& c, nb::handle rate_lower, nb::handle rate_upper, nb::handle position_lower,
                       nb::handle position_upper, nb::handle acceleration, double speed, int closing) {
  const int n = c.n();
  stillreach::ControllerState& s = c.state;
  const auto copy = [&](nb::handle from, const double* to) {
    read_vector("limits", from, n, const_cast<double*>(to), false);
  };
  copy(rate_lower, s.rate_lower);
  copy(rate_upper, s.rate_upper);
  copy(acceleration, s.acceleration);
  copy(position_lower, s.position_lower);
  copy(position_upper, s.position_upper);
  s.speed = speed;
  s.constant_bounds = 1;
  s.bounds_stand = 0;
  for (int i = 0; i < n; ++i) {
    s.constant_bounds &=
        std::isinf(s.position_lower[i]) && std::isinf(s.position_upper[i]) && std::isinf(s.acceleration[i]);
    s.closing[i] = static_cast<std::int8_t>(s.closing[i] | closing);
  }
  kernel().bound_correction(s);
}

// What the controller did and what is broken, for a copy of it.
template <class Visit>
static void each_memory(stillreach::ControllerState& s, int n, Visit visit) {
  for (int i = 0; i < n; ++i) {
    visit(&s.faults[i].health, 1);
    visit(s.faults[i].number, 2);
  }
  visit(s.last, n);
  visit(s.anchor, n);
  visit(&s.transition, 1);
  visit(s.multiplier.u, 6);
  visit(s.multiplier.kappa, stillreach::kParts);
  visit(&s.multiplier.raised, 1);
  visit(&s.multiplier.known, 1);
  visit(s.active, n);
  visit(s.closing, n);
}

static nb::bytes get_state(Controller& c) {
  std::string all;
  const auto add = [&](const auto* from, int count) {
    all.append(reinterpret_cast<const char*>(from), sizeof *from * to_size(count));
  };
  each_memory(c.state, c.n(), add);
  return nb::bytes(all.data(), all.size());
}

static void set_state(Controller& c, nb::bytes state) {
  const int n = c.n();
  std::size_t wanted = 0;
  each_memory(c.state, n, [&](auto* to, int count) { wanted += sizeof *to * to_size(count); });
  if (state.size() != wanted)
    refuse("state", std::to_string(state.size()) + " bytes", std::to_string(wanted) + " bytes");
  const char* at = static_cast<const char*>(state.data());
  const auto take = [&](auto* to, int count) {
    std::memcpy(to, at, sizeof *to * to_size(count));
    at += sizeof *to * to_size(count);
  };
  each_memory(c.state, n, take);
  c.state.bounds_stand = 0;
  kernel().bound_correction(c.state);
}

// Everything that the controller was told, as numbers in a row: the head, then the settings.
static nb::bytes get_setup(Controller& c) {
  if (c.next) c.take_next();
  const stillreach::SetupHead head = stillreach::head_of(c.state);
  std::vector<double> all;
  for (int size :
       {head.n, head.moved, head.coupled, head.m, head.has_rows, head.has_units, head.has_columns, head.full})
    all.push_back(size);
  stillreach::each_setting(c.state, [&all](const auto& value) { all.push_back(static_cast<double>(value)); });
  return nb::bytes(all.data(), all.size() * sizeof(double));
}

// Runs a tick and takes what it answers. All memory is found before the tick, so that it runs whole or not at all.
static Solution solution_of_tick(Controller& c, const double* q, const double* twist, const double* target,
                                 double period, nb::handle out) {
  const int n = c.n(), m = c.state.m;
  Solution s;
  s.metric = c.metric;
  s.m = m;
  s.n = n;
  s.rank_tolerance = c.state.law.rank_tolerance;
  s.make_room();
  s.rates = out.is_none() ? new_vector(n) : nb::borrow(out);
  View view;
  double* to = numpy_vector(s.rates, n, true);
  if (!to) {
    view = strict("out", s.rates, {n}, true);
    to = view.data();
  }
  c.run(q, twist, target, period);
  std::copy_n(c.rates.data(), n, to);
  std::copy_n(c.state.task_jacobian, m * n, s.jacobian());
  std::copy_n(c.state.lower, n, s.lower());
  std::copy_n(c.state.upper, n, s.upper());
  std::copy_n(c.state.twist, m, s.twist());
  std::copy_n(c.residual.data(), m, s.residual());
  std::int8_t* const reasons = s.reasons();
  for (int i = 0; i < n; ++i)
    reasons[i] = stillreach::active_reason(c.answer.active[i], c.state.lower_reason[i], c.state.upper_reason[i]);
  s.status = c.answer.status;
  s.iterations = c.answer.iterations;
  s.damping = c.answer.damping;
  s.scale = c.answer.scale;
  s.task_error = c.answer.task_error;
  s.set_multiplier(c.state.multiplier);
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

// The arrays of a bound tick, held open for as long as it lives. What a tick needs comes first, in one line of the
// cache.
struct BoundTick {
  Controller* c = nullptr;                    // null once the garbage collector took it apart
  const double *q, *twist, *target, *period;  // target, period: or null
  double* rates;
  nb::object controller;
  View views[5];  // they own the arrays
};

static nb::object tick(BoundTick& b) {
  if (!b.c) throw std::runtime_error("the controller of this tick is gone");
  Controller& c = *b.c;
  double frame[12];
  const double *q = b.q, *twist = b.twist;
  const double period = b.period ? *b.period : 0.0, unknown[6] = {std::nan("")};
  bool fine = true;
  if (b.target && !kernel().read_pose(b.target, frame)) frame[0] = std::nan("");
  if (b.period && !(period > 0.0 && std::isfinite(period))) twist = unknown;
  if (c.gradient.is_valid() || c.next) {
    bool finite = true;
    for (int i = 0; i < c.n(); ++i) finite &= std::isfinite(q[i]);
    if (finite) fine = c.prepare(q, false);
  }
  c.run(q, twist, b.target ? frame : nullptr, twist == unknown ? 0.0 : period);
  std::copy_n(c.rates.data(), c.n(), b.rates);
  return status_object(fine ? c.answer.status : c.answer.status | stillreach::INVALID_INPUT);
}

// tick() as Python calls it: a built-in function without arguments, which costs less than a bound method.
static PyObject* call_tick(PyObject* self, PyObject*) {
  try {
    return tick(*nb::inst_ptr<BoundTick>(self)).release().ptr();
  } catch (nb::python_error& error) {
    error.restore();
  } catch (const std::bad_alloc&) {
    PyErr_NoMemory();
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
  }
  return nullptr;
}

static nb::object bind(nb::pointer_and_handle<Controller> self, nb::handle q, nb::handle twist, nb::handle rates,
                       nb::handle target, nb::handle period) {
  static PyMethodDef method{"tick", &call_tick, METH_NOARGS,
                            "One tick on the bound arrays: reads them, writes the rates, returns the Status."};
  Controller& c = *self.p;
  const nb::object owner = nb::inst_alloc(nb::type<BoundTick>());
  BoundTick* const b = new (nb::inst_ptr<BoundTick>(owner)) BoundTick();
  nb::inst_mark_ready(owner);
  b->views[0] = strict("q", q, {c.n()}, false);
  b->views[1] = strict("twist", twist, {6}, false);
  b->views[2] = strict("rates", rates, {c.n()}, true);
  if (!target.is_none()) b->views[3] = strict("target", target, {4, 4}, false);
  if (!period.is_none()) b->views[4] = strict("period", period, {1}, false);
  b->q = b->views[0].data();
  b->twist = b->views[1].data();
  b->rates = b->views[2].data();
  b->target = target.is_none() ? nullptr : b->views[3].data();
  b->period = period.is_none() ? nullptr : b->views[4].data();
  b->controller = nb::borrow(self.h);
  b->c = &c;
  PyObject* const function = PyCFunction_NewEx(&method, owner.ptr(), nullptr);
  if (!function) nb::raise_python_error();
  return nb::steal(function);
}

// The garbage collector's view of what a controller and a bound tick own.
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

static int visit_tick(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  const BoundTick& b = *nb::inst_ptr<BoundTick>(self);
  Py_VISIT(b.controller.ptr());
  for (const View& view : b.views) Py_VISIT(view.owner());
  return 0;
}

static int clear_tick(PyObject* self) {
  if (nb::inst_ready(self)) const BoundTick taken = std::exchange(*nb::inst_ptr<BoundTick>(self), BoundTick());
  return 0;
}

static PyType_Slot controller_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_controller)},
                                         {Py_tp_clear, reinterpret_cast<void*>(&clear_controller)},
                                         {0, nullptr}};
static PyType_Slot tick_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_tick)},
                                   {Py_tp_clear, reinterpret_cast<void*>(&clear_tick)},
                                   {0, nullptr}};

static void set_fault(Controller& c, int joint, stillreach::Health health, double first, double second) {
  kernel().set_fault(c.state, joint, {health, {first, second}});
}

static void reset(Controller& c, nb::handle rates) {
  if (rates.is_none())
    std::fill_n(c.state.last, c.n(), 0.0);
  else {
    std::vector<double> read(to_size(c.n()));
    read_vector("rates", rates, c.n(), read.data(), true, c.labels);
    std::copy_n(read.data(), c.n(), c.state.last);
  }
  std::fill_n(c.state.active, c.n(), std::int8_t{0});
  c.state.transition = 0.0;
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
  nb::class_<BoundTick>(m, "BoundTick", nb::type_slots(tick_slots),
                        "The arrays that Controller.bind() bound, held open.");
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
  c.def(
      "bind", &bind, nb::kw_only(), nb::arg("q").none(), nb::arg("twist").none(), nb::arg("rates").none(),
      nb::arg("target").none() = nb::none(), nb::arg("period").none() = nb::none(),
      nb::sig("def bind(self, *, q: numpy.typing.NDArray[numpy.float64], twist: numpy.typing.NDArray[numpy.float64], "
              "rates: "
              "numpy.typing.NDArray[numpy.float64], target: numpy.typing.NDArray[numpy.float64] | None = None, period: "
              "numpy.typing.NDArray[numpy.float64] | None = None) -> collections.abc.Callable[[], "
              "stillreach.status.Status]"),
      "Binds arrays once and returns a function tick() for a loop.\n\n"
      "Each call reads q (n,), twist (6,), and, if given, target (4, 4), the pose to track with twist as feedforward, "
      "and period (1,) "
      "[s], for which the rates are held. It writes rates (n,) in place and returns the Status. It raises no "
      "Exception: non-finite "
      "input, an invalid target and a period that is not positive give INVALID_INPUT and braking. Ctrl-C in a gradient "
      "is raised, and "
      "the tick is left out. Inputs are read before rates are written, so the arrays may overlap.");
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
        for (const stillreach::Fault& fault : s.faults) codes.push_back(static_cast<char>(fault.health));
        return numpy.attr("frombuffer")(nb::bytes(codes.data(), codes.size()), nb::arg("dtype") = numpy.attr("int8"));
      },
      nb::sig("def health(self) -> numpy.typing.NDArray[numpy.int8]"), "(n,) Health of each joint.");
  c.def_prop_ro(
      "last_rates",
      [](const Controller& s) {
        nb::object array = new_vector(s.n());
        View view;
        view.open(array);
        std::copy_n(s.state.last, s.n(), view.data());
        return array;
      },
      nb::sig("def last_rates(self) -> numpy.typing.NDArray[numpy.float64]"), "(n,) the last commanded rates.");
  bind_rollout(m, c);
  m.attr("RIGID_TOLERANCE") = stillreach::kRigid;
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
}
