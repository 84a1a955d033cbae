#include "controller.hpp"

#include <cmath>
#include <cstring>

static const double kRigid = 1e-9;  // as _door.RIGID_TOLERANCE

bool read_pose(const double* T, double* frame) {
  bool right = T[12] == 0.0 && T[13] == 0.0 && T[14] == 0.0 && T[15] == 1.0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) frame[3 * c + r] = T[4 * r + c], right &= std::isfinite(T[4 * r + c]);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b <= a; ++b) {
      double dot = 0.0;
      for (int r = 0; r < 3; ++r) dot += frame[3 * a + r] * frame[3 * b + r];
      right &= std::fabs(dot - (a == b)) <= kRigid;
    }
  const double* f = frame;
  const double det = f[0] * (f[4] * f[8] - f[5] * f[7]) - f[3] * (f[1] * f[8] - f[2] * f[7]) + f[6] * (f[1] * f[5] - f[2] * f[4]);
  return right && det > 0.0;
}

bool Controller::update_gradient(const double* q, bool raise) {
  double* to = const_cast<double*>(state.null_vector);
  try {
    nb::object at = new_vector(n());
    View view;
    view.open(at);
    std::memcpy(view.data(), q, sizeof(double) * n());
    nb::object value = gradient(at);
    std::vector<double> read(n());
    read_vector("gradient(q)", value, n(), read.data());
    std::memcpy(to, read.data(), sizeof(double) * n());
    return true;
  } catch (nb::python_error& error) {
    if (raise) throw;
    error.discard_as_unraisable("stillreach: the null motion's gradient");
  }
  std::memset(to, 0, sizeof(double) * n());
  return false;
}

static void make_controller(Controller* self, const Arm& arm, const Law& law, const Metric& metric, nb::sequence rows, bool tool_axes,
                            double period, nb::handle rate_lower, nb::handle rate_upper, nb::handle position_lower,
                            nb::handle position_upper, nb::handle acceleration, double return_rate, double transition_rate,
                            double track_gain, double track_linear, double track_angular) {
  new (self) Controller();
  Controller& c = *self;
  c.arm = arm, c.metric = metric.data;
  const int n = arm.n, m = static_cast<int>(nb::len(rows));
  stillreach::ControllerState& s = c.state;
  s.arm = c.arm.view(), s.law = law.settings, s.metric = c.metric->view(), s.m = m;
  s.every_row = m == 6 && !tool_axes, s.tool_axes = tool_axes;
  for (int r = 0; r < m; ++r) s.rows[r] = nb::cast<int>(rows[r]), s.every_row = s.every_row && s.rows[r] == r;
  s.period = period, s.return_rate = return_rate, s.transition_rate = transition_rate;
  s.track_gain = track_gain, s.track_linear = track_linear, s.track_angular = track_angular;
  s.null_kind = stillreach::NULL_NONE, s.null_largest = std::numeric_limits<double>::infinity();

  c.numbers.assign(34 * static_cast<std::size_t>(n), 0.0), c.bytes.assign(4 * static_cast<std::size_t>(n), 0);
  double* at = c.numbers.data();
  const auto take = [&](int times) { double* p = at; at += static_cast<std::size_t>(times) * n; return p; };
  const auto copy = [&](const char* name, nb::handle from) {
    double* p = take(1);
    read_vector(name, from, n, p, false);
    return p;
  };
  s.rate_lower = copy("rate_limits", rate_lower), s.rate_upper = copy("rate_limits", rate_upper);
  s.position_lower = copy("position_limits", position_lower), s.position_upper = copy("position_limits", position_upper);
  s.acceleration = copy("acceleration_limits", acceleration);
  s.null_vector = take(1), s.fault_value = take(1), s.last = take(1), s.anchor = take(1), s.lower = take(1), s.upper = take(1), s.reference = take(1);
  s.task_jacobian = s.every_row ? nullptr : take(6), s.scratch = take(10), s.jacobian = take(6);
  if (s.every_row) s.task_jacobian = s.jacobian;
  s.constant_bounds = 1;
  for (int i = 0; i < n; ++i)
    s.constant_bounds &= std::isinf(s.position_lower[i]) && std::isinf(s.position_upper[i]) && std::isinf(s.acceleration[i]);
  s.health = c.bytes.data(), s.active = s.health + n, s.lower_reason = s.active + n, s.upper_reason = s.lower_reason + n;
  c.rates.assign(n, 0.0), c.measured.assign(n, 0.0), c.residual.assign(6, 0.0), c.active.assign(n, 0);
  c.answer.rates = c.rates.data(), c.answer.residual = c.residual.data(), c.answer.active = c.active.data();
  c.scratch.fit(n, !c.metric->joints.empty());
}

// to: the numbers of `out`, where there is one.
static Solution take_solution(Controller& c, nb::handle out, double* to) {
  const int n = c.n(), m = c.state.m;
  Solution s;
  s.metric = c.metric, s.m = m, s.n = n, s.rank_tolerance = c.state.law.rank_tolerance;
  if (out.is_none()) {
    s.rates = new_vector(n);
    View view;
    to = numpy_vector(s.rates, n, true);
    if (!to && view.open(s.rates)) to = view.data();
  } else {
    s.rates = nb::borrow(out);
  }
  std::memcpy(to, c.rates.data(), sizeof(double) * n);
  s.make_room();
  std::memcpy(s.jacobian(), c.state.task_jacobian, sizeof(double) * m * n);
  std::memcpy(s.lower(), c.state.lower, sizeof(double) * n);
  std::memcpy(s.upper(), c.state.upper, sizeof(double) * n);
  std::memcpy(s.twist(), c.state.twist, sizeof(double) * m);
  std::memcpy(s.residual(), c.residual.data(), sizeof(double) * m);
  std::int8_t* const reasons = s.reasons();
  for (int i = 0; i < n; ++i) reasons[i] = active_reason(c.active[i], c.state.lower_reason[i], c.state.upper_reason[i]);
  s.status = c.answer.status, s.iterations = c.answer.iterations, s.damping = c.answer.damping, s.scale = c.answer.scale;
  s.task_error = c.answer.task_error;
  return s;
}

// The numbers of `out` (n,), null where there is none; view keeps it open where it is no plain NumPy array.
static double* open_out(nb::handle out, long n, View& view) {
  if (out.is_none()) return nullptr;
  if (double* to = numpy_vector(out, n, true)) return to;
  view = strict("out", out, {n}, true);
  return view.data();
}

static Solution step(Controller& c, nb::handle q, nb::handle twist, nb::handle out) {
  std::vector<double>& at = c.measured;
  double command[6];
  View view;
  double* const to = open_out(out, c.n(), view);
  read_vector("q", q, c.n(), at.data());
  read_vector("twist", twist, 6, command);
  if (!c.gradient.is_none()) c.update_gradient(at.data(), true);
  c.run(at.data(), command, nullptr);
  return take_solution(c, out, to);
}

static Solution track(Controller& c, nb::handle q, nb::handle target_pose, nb::handle feedforward, nb::handle out) {
  std::vector<double>& at = c.measured;
  double command[6] = {0, 0, 0, 0, 0, 0}, target[12];
  View view;
  double* const to = open_out(out, c.n(), view);
  read_vector("q", q, c.n(), at.data());
  View matrix;
  nb::object converted;
  if (!(matrix.open(target_pose) && matrix.is_double() && matrix.is_contiguous() && matrix.ndim() == 2 && matrix.size(0) == 4 && matrix.size(1) == 4)) {
    converted = nb::module_::import_("stillreach._door").attr("pose")("target_pose", target_pose);
    matrix = strict("target_pose", converted, {4, 4}, false);
  }
  if (!read_pose(matrix.data(), target)) {
    nb::module_::import_("stillreach._door").attr("pose")("target_pose", target_pose);
    refuse("target_pose", describe(target_pose), "a rigid transform (4 x 4)");
  }
  if (!feedforward.is_none()) read_vector("feedforward", feedforward, 6, command);
  if (!c.gradient.is_none()) c.update_gradient(at.data(), true);
  c.run(at.data(), command, target);
  return take_solution(c, out, to);
}

// The arrays of a bound tick, held open for as long as it lives. What a tick needs comes first, in one line of the cache.
struct Bound {
  Controller* c;
  const double *q, *twist, *target;  // target: or null
  double* rates;
  nb::object controller, arrays;
  View views[4];
};

static nb::object tick(Bound& b) {
  Controller& c = *b.c;
  double frame[12];
  const double* q = b.q;
  bool fine = true;
  if (b.target && !read_pose(b.target, frame)) frame[0] = std::nan("");
  if (!c.gradient.is_none()) {
    bool finite = true;
    for (int i = 0; i < c.n(); ++i) finite &= std::isfinite(q[i]);
    if (finite) fine = c.update_gradient(q, false);
  }
  c.run(q, b.twist, b.target ? frame : nullptr);
  std::memcpy(b.rates, c.rates.data(), sizeof(double) * c.n());
  return status_object(fine ? c.answer.status : c.answer.status | stillreach::INVALID_INPUT);
}

static nb::object bind(nb::handle self, nb::handle q, nb::handle twist, nb::handle rates, nb::handle target) {
  Controller& c = *nb::inst_ptr<Controller>(self);
  auto b = std::make_unique<Bound>();
  b->controller = nb::borrow(self), b->arrays = nb::make_tuple(q, twist, rates, target), b->c = &c;
  b->views[0] = strict("q", q, {c.n()}, false);
  b->views[1] = strict("twist", twist, {6}, false);
  b->views[2] = strict("rates", rates, {c.n()}, true);
  if (!target.is_none()) b->views[3] = strict("target", target, {4, 4}, false);
  b->q = b->views[0].data(), b->twist = b->views[1].data(), b->rates = b->views[2].data();
  b->target = target.is_none() ? nullptr : b->views[3].data();
  return nb::cpp_function([bound = std::shared_ptr<Bound>(std::move(b))]() { return tick(*bound); }, nb::name("tick"));
}

static void set_health(Controller& c, int joint, int health, double value) {
  kernel().set_health(c.state, joint, health, value);
}

static void reset(Controller& c, nb::handle rates) {
  if (rates.is_none())
    std::memset(c.state.last, 0, sizeof(double) * c.n());
  else
    read_vector("rates", rates, c.n(), c.measured.data()), std::memcpy(c.state.last, c.measured.data(), sizeof(double) * c.n());
  std::memset(c.state.active, 0, c.n());
  c.state.transition = 0.0;
}

static void set_null_motion(Controller& c, int kind, double gain, double largest, nb::handle vector, nb::handle gradient) {
  std::vector<double> read(c.n(), 0.0);
  if (!vector.is_none()) read_vector("null_motion", vector, c.n(), read.data());
  std::memcpy(const_cast<double*>(c.state.null_vector), read.data(), sizeof(double) * c.n());
  c.state.null_kind = kind, c.state.null_gain = gain, c.state.null_largest = largest;
  c.gradient = nb::borrow(gradient);
}

void bind_controller(nb::module_& m) {
  nb::class_<Controller> c(m, "ControllerCore", "The compiled part of stillreach.Controller.");
  c.def("__init__",
        [](Controller* self, const Arm& arm, const Law& law, const Metric& metric, nb::sequence rows, bool tool_axes, double period,
           nb::handle rate_lower, nb::handle rate_upper, nb::handle position_lower, nb::handle position_upper, nb::handle acceleration,
           double return_rate, double transition_rate, double track_gain, double track_linear, double track_angular) {
          make_controller(self, arm, law, metric, rows, tool_axes, period, rate_lower, rate_upper, position_lower, position_upper,
                          acceleration, return_rate, transition_rate, track_gain, track_linear, track_angular);
          self->gradient = nb::none();
        },
        nb::kw_only(), nb::arg("arm"), nb::arg("law"), nb::arg("metric"), nb::arg("rows"), nb::arg("tool_axes"), nb::arg("period"),
        nb::arg("rate_lower"), nb::arg("rate_upper"), nb::arg("position_lower"), nb::arg("position_upper"), nb::arg("acceleration"),
        nb::arg("return_rate"), nb::arg("transition_rate"), nb::arg("track_gain"), nb::arg("track_linear"), nb::arg("track_angular"));
  c.def("step", &step, nb::arg("q").none(), nb::arg("twist").none(), nb::kw_only(), nb::arg("out").none() = nb::none(),
        nb::sig("def step(self, q: numpy.typing.ArrayLike, twist: numpy.typing.ArrayLike, *, "
                "out: numpy.typing.NDArray[numpy.float64] | None = None) -> Solution"),
        "One tick: q (n,) [rad, m] measured, twist (6,) [m/s, rad/s] commanded along base axes -> Solution.\n\n"
        "out (n,) receives the rates instead of a new array. Raises InputError for anything that is not finite or not of the right "
        "shape; the controller is then as it was.");
  c.def("track", &track, nb::arg("q").none(), nb::arg("target_pose").none(), nb::arg("feedforward").none() = nb::none(), nb::kw_only(),
        nb::arg("out").none() = nb::none(),
        nb::sig("def track(self, q: numpy.typing.ArrayLike, target_pose: numpy.typing.ArrayLike, feedforward: "
                "numpy.typing.ArrayLike | None = None, *, out: numpy.typing.NDArray[numpy.float64] | None = None) -> Solution"),
        "One tick that closes the loop on the tool's pose: target_pose (4, 4) [m] in the base frame, feedforward (6,) the twist "
        "that the target moves with -> Solution.");
  c.def("bind", [](nb::handle self, nb::handle q, nb::handle twist, nb::handle rates, nb::handle target) { return bind(self, q, twist, rates, target); },
        nb::kw_only(), nb::arg("q").none(), nb::arg("twist").none(), nb::arg("rates").none(), nb::arg("target").none() = nb::none(),
        nb::sig("def bind(self, *, q: numpy.typing.NDArray[numpy.float64], twist: numpy.typing.NDArray[numpy.float64], rates: "
                "numpy.typing.NDArray[numpy.float64], target: numpy.typing.NDArray[numpy.float64] | None = None) -> "
                "collections.abc.Callable[[], stillreach.status.Status]"),
        "Binds arrays once: the returned tick() reads q (n,) and twist (6,), with target (4, 4) the pose to track and twist the "
        "feedforward, writes rates (n,) in place and returns the Status. It never raises: input that is not finite is answered "
        "with INVALID_INPUT and braking. Inputs are read before rates are written, so that the arrays may overlap.");
  c.def("_set_health", &set_health, nb::arg("joint"), nb::arg("health"), nb::arg("value"));
  c.def("_reset", &reset, nb::arg("rates").none());
  c.def("_set_null_motion", &set_null_motion, nb::arg("kind"), nb::arg("gain"), nb::arg("largest"), nb::arg("vector").none(),
        nb::arg("gradient").none());
  c.def_prop_ro("health", [](const Controller& s) {
    nb::object numpy = nb::module_::import_("numpy");
    return numpy.attr("frombuffer")(nb::bytes(reinterpret_cast<const char*>(s.state.health), s.n()), nb::arg("dtype") = numpy.attr("int8"));
  }, nb::sig("def health(self) -> numpy.typing.NDArray[numpy.int8]"), "(n,) 0 healthy, 1 locked, 2 derated, 3 runaway.");
  c.def_prop_ro("last_rates", [](const Controller& s) {
    nb::object array = new_vector(s.n());
    View view;
    view.open(array);
    std::memcpy(view.data(), s.state.last, sizeof(double) * s.n());
    return array;
  }, nb::sig("def last_rates(self) -> numpy.typing.NDArray[numpy.float64]"), "(n,) the last commanded rates.");
  bind_rollout(c);
}
