// Bound ticks: arrays that a loop binds once, and a function without arguments that does the tick.
#include "controller.hpp"

#include <algorithm>
#include <cmath>

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
  std::copy_n(c.core.answer.rates, c.n(), b.rates);
  return status_object(fine ? c.core.answer.status : c.core.answer.status | stillreach::INVALID_INPUT);
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

// The garbage collector's view of what a bound tick owns.
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

static PyType_Slot tick_slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_tick)},
                                   {Py_tp_clear, reinterpret_cast<void*>(&clear_tick)},
                                   {0, nullptr}};

void bind_bound_tick(nb::module_& m, nb::class_<Controller>& c) {
  nb::class_<BoundTick>(m, "BoundTick", nb::type_slots(tick_slots),
                        "The arrays that Controller.bind() bound, held open.");
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
}
