#include "solution.hpp"

#include <algorithm>
#include <cstring>

nb::object status_object(std::int32_t value) {
  static PyObject* members[2 * stillreach::INVALID_INPUT] = {};
  PyObject*& member = members[value & (2 * stillreach::INVALID_INPUT - 1)];
  if (!member) member = nb::object(nb::module_::import_("stillreach.status").attr("Status")(value)).release().ptr();
  return nb::borrow(member);
}

// A read-only NumPy copy of `count` numbers.
static nb::object copy_out(const double* from, nb::object shape, int count) {
  nb::object array = new_array(shape);
  View view;
  view.open(array);
  std::copy_n(from, count, view.data());
  array.attr("setflags")(nb::arg("write") = false);
  return array;
}

static nb::object jacobian_out(const Solution& s) {
  nb::object by_columns = copy_out(s.jacobian(), nb::make_tuple(s.n, s.m), s.m * s.n);
  return by_columns.attr("T");
}

static nb::object active_out(const Solution& s) {
  nb::object numpy = nb::module_::import_("numpy");
  return numpy.attr("frombuffer")(nb::bytes(reinterpret_cast<const char*>(s.reasons()), to_size(s.n)),
                                  nb::arg("dtype") = numpy.attr("int8"));
}

// What turns a twist in the task's rows into weighted units, (m, m).
static nb::object row_weights_out(const Solution& s) {
  const std::vector<double>& rows = s.metric->rows;
  if (!rows.empty()) return copy_out(rows.data(), nb::make_tuple(s.m, s.m), s.m * s.m);
  return nb::module_::import_("numpy").attr("eye")(s.m);
}

// The Jacobian in weighted units, R J C (m, n); with a full joint weight C holds the joint units alone.
static nb::object weighted_out(const Solution& s) {
  nb::object J = jacobian_out(s);
  const MetricData& metric = *s.metric;
  if (!metric.rows.empty()) J = row_weights_out(s).attr("__matmul__")(J);
  if (!metric.columns.empty()) J = J * copy_out(metric.columns.data(), nb::make_tuple(s.n), s.n);
  return J;
}

static nb::bytes raw(const void* from, std::size_t count) { return nb::bytes(static_cast<const char*>(from), count); }

static nb::tuple get_state(const Solution& s) {
  const MetricData& metric = *s.metric;
  const auto numbers = [](const std::vector<double>& from) { return raw(from.data(), sizeof(double) * from.size()); };
  return nb::make_tuple(s.rates, s.m, s.n, s.status, s.iterations, s.damping, s.scale, s.task_error, s.rank_tolerance,
                        raw(s.numbers.get(), s.memory_bytes()), numbers(metric.rows), numbers(metric.units),
                        numbers(metric.columns), numbers(metric.joints));
}

static void set_state(Solution& to, nb::tuple state) {
  const auto fail = [&] { refuse("state", describe(state).substr(0, 80), "the state of a Solution"); };
  if (nb::len(state) != 14) fail();
  Solution s;
  int at = 0;
  const auto next = [&] { return state[at++]; };
  s.rates = nb::borrow(next());
  s.m = nb::cast<int>(next());
  s.n = nb::cast<int>(next());
  s.status = nb::cast<std::int32_t>(next());
  s.iterations = nb::cast<int>(next());
  s.damping = nb::cast<double>(next());
  s.scale = nb::cast<double>(next());
  s.task_error = nb::cast<double>(next());
  s.rank_tolerance = nb::cast<double>(next());
  if (s.m < 1 || s.m > 6 || s.n < 1 || s.status < 0 || s.status >= 2 * stillreach::INVALID_INPUT) fail();
  const nb::bytes numbers = nb::cast<nb::bytes>(next());
  if (numbers.size() != s.memory_bytes()) fail();
  s.make_room();
  std::memcpy(s.numbers.get(), numbers.data(), numbers.size());
  auto metric = std::make_shared<MetricData>();
  metric->m = s.m;
  metric->n = s.n;
  const std::size_t m = to_size(s.m), n = to_size(s.n);
  const std::pair<std::vector<double>*, std::size_t> parts[] = {
      {&metric->rows, m * m}, {&metric->units, n}, {&metric->columns, n}, {&metric->joints, n * n}};
  for (const auto& [part, count] : parts) {
    const nb::bytes from = nb::cast<nb::bytes>(next());
    if (from.size() != 0 && from.size() != sizeof(double) * count) fail();
    part->resize(from.size() / sizeof(double));
    if (from.size() != 0) std::memcpy(part->data(), from.data(), from.size());
  }
  s.metric = std::move(metric);
  new (&to) Solution(std::move(s));
}

// The garbage collector's view: `rates` may be an array of the caller's that leads back here.
static int visit_solution(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (nb::inst_ready(self)) Py_VISIT(nb::inst_ptr<Solution>(self)->rates.ptr());
  return 0;
}

static int clear_solution(PyObject* self) {
  if (nb::inst_ready(self)) nb::inst_ptr<Solution>(self)->rates.reset();
  return 0;
}

static PyType_Slot solution_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_solution)},
                                       {Py_tp_clear, reinterpret_cast<void*>(&clear_solution)},
                                       {0, nullptr}};

void bind_solution(nb::module_& m) {
  const auto call = [](const char* name) {
    return [name](nb::handle self, nb::args args, nb::kwargs kwargs) {
      return nb::module_::import_("stillreach.insight").attr(name)(self, *args, **kwargs);
    };
  };
  using Array = nb::object;
#define STILLREACH_ARRAY(name) nb::sig("def " name "(self) -> numpy.typing.NDArray[numpy.float64]")
  nb::class_<Solution>(m, "Solution", nb::type_slots(solution_slots), "What a law answered for one tick.")
      .def_prop_ro(
          "rates", [](const Solution& s) -> Array { return s.rates.is_valid() ? s.rates : nb::none(); },
          STILLREACH_ARRAY("rates"), "(n,) [rad/s, m/s] joint rates.")
      .def_prop_ro(
          "status", [](const Solution& s) { return status_object(s.status); },
          nb::sig("def status(self) -> stillreach.status.Status"), "What happened, as flags.")
      .def_ro("damping", &Solution::damping, "Damping factor kappa, in the units of the weighted J J'.")
      .def_ro("scale", &Solution::scale, "Fraction of the commanded twist that was aimed at (KeepDirection; else 1).")
      .def_ro("task_error", &Solution::task_error, "Weighted norm of the residual.")
      .def_ro("iterations", &Solution::iterations, "Factorisations, or steps of the damping search.")
      .def_prop_ro(
          "weightless", [](const Solution& s) { return s.metric->weightless; },
          "Rank that the weight of the task lacks: so many of the last weighted rows are 0.")
      .def_ro("rank_tolerance", &Solution::rank_tolerance, "Relative to the largest singular value.")
      .def_prop_ro(
          "residual", [](const Solution& s) { return copy_out(s.residual(), nb::make_tuple(s.m), s.m); },
          STILLREACH_ARRAY("residual"), "(m,) twist - J rates, unweighted.")
      .def_prop_ro(
          "multiplier", [](const Solution& s) { return copy_out(s.multiplier(), nb::make_tuple(s.m), s.m); },
          STILLREACH_ARRAY("multiplier"),
          "(m,) of LeastError with a price: the rates are reference + W2^-1 J' multiplier, cut to the bounds; else "
          "zeros.")
      .def_prop_ro("active", &active_out, nb::sig("def active(self) -> numpy.typing.NDArray[numpy.int8]"),
                   "(n,) which bounds are met and why: 0 none, else stillreach.Reason, negative at the lower bound.")
      .def_prop_ro(
          "twist", [](const Solution& s) { return copy_out(s.twist(), nb::make_tuple(s.m), s.m); },
          STILLREACH_ARRAY("twist"), "(m,) what was commanded, in the task's rows.")
      .def_prop_ro(
          "lower", [](const Solution& s) { return copy_out(s.lower(), nb::make_tuple(s.n), s.n); },
          STILLREACH_ARRAY("lower"), "(n,) lower bounds of the rates.")
      .def_prop_ro(
          "upper", [](const Solution& s) { return copy_out(s.upper(), nb::make_tuple(s.n), s.n); },
          STILLREACH_ARRAY("upper"), "(n,) upper bounds of the rates.")
      .def_prop_ro("jacobian", &jacobian_out, STILLREACH_ARRAY("jacobian"), "(m, n) the Jacobian that was used.")
      .def_prop_ro("weighted_jacobian", &weighted_out, STILLREACH_ARRAY("weighted_jacobian"),
                   "(m, n) the same in the units and weights of the law.")
      .def_prop_ro("row_weights", &row_weights_out, STILLREACH_ARRAY("row_weights"),
                   "(m, m) what turns a twist in the task's rows into weighted units.")
      .def("singular_values", call("singular_values"),
           nb::sig("def singular_values(self) -> numpy.typing.NDArray[numpy.float64]"),
           "(min(m, working joints),) of the working joints' weighted Jacobian, falling.")
      .def("lost_directions", call("lost_directions"),
           nb::sig("def lost_directions(self, *, rates: numpy.typing.ArrayLike | None = None, "
                   "least: numpy.typing.ArrayLike | None = None) -> numpy.typing.NDArray[numpy.float64]"),
           "(m, lost) orthonormal basis of the unit twists in which full rates of the working joints give less than "
           "least: "
           "by default 1 mm/s and 0.1 deg/s, at rates of 1 rad/s and 1 m/s.")
      .def("weak_directions", call("weak_directions"),
           nb::sig("def weak_directions(self, threshold: float) -> numpy.typing.NDArray[numpy.float64]"),
           "(m, weak) unit twists whose gain falls below the threshold, weakest first.")
      .def("check", call("check"), nb::sig("def check(self) -> stillreach.insight.Check"),
           "Recomputes every promise from the data of this answer.")
      .def("__getstate__", &get_state, nb::sig("def __getstate__(self) -> tuple"))
      .def("__setstate__", &set_state, nb::arg("state"), nb::sig("def __setstate__(self, state: tuple) -> None"))
      .def(
          "__repr__", [](nb::handle self) { return nb::module_::import_("stillreach.insight").attr("text")(self); },
          nb::sig("def __repr__(self) -> str"));
#undef STILLREACH_ARRAY
}
