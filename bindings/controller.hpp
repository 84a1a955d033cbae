// The controller's memory, and its tick as Python calls it.
#pragma once

#include "solution.hpp"

// A null motion as _set_null_motion() brings it.
struct NullMotion {
  stillreach::NullMotionKind kind;
  double gain, largest;
  int failures;                // of TOLERANCE: how many joints are lost at once
  std::vector<double> vector;  // n
  nb::object gradient;         // a callable q -> (n,); invalid without one
};

struct Controller {
  Arm arm;
  std::shared_ptr<const MetricData> metric;
  stillreach::ControllerState state{};
  Scratch scratch;
  std::vector<double> numbers;  // everything that `state` points to
  std::vector<std::int8_t> bytes;
  std::vector<stillreach::Fault> faults;
  std::vector<double> rates, residual;
  std::vector<double> measured, proposed;  // leased to one call at a time
  std::vector<std::int8_t> active;
  stillreach::Answer answer{};
  std::int64_t ticks = 0;            // so far
  nb::object gradient;               // the null motion's, evaluated before each tick; invalid without one
  std::unique_ptr<NullMotion> next;  // the null motion from the next tick on, where it was set since the last one
  nb::object labels;                 // _door.Labels of the joints

  int n() const { return state.arm.n; }
  // period: [s] of this tick alone, 0 for the controller's own.
  void run(const double* q, const double* twist, const double* target, double period) {
    const double own = state.period;
    if (period > 0.0) {
      state.period = period;
      state.uneven = 1;
    }
    kernel().tick(state, q, twist, target, scratch.memory(), answer);
    ++ticks;
    state.period = own;
    state.uneven = 0;
  }
  // Called before each tick: takes over a null motion that was set meanwhile, and evaluates its gradient at q. False,
  // with the null motion off for this tick, where the gradient failed and `raise` is false; what is no Exception, such
  // as KeyboardInterrupt, is raised in any case.
  bool prepare(const double* q, bool raise) {
    if (next) take_next();
    return !gradient.is_valid() || update_gradient(q, raise);
  }
  void take_next();

 private:
  bool update_gradient(const double* q, bool raise);
};

// Reads a pose (4, 4) to follow: rotation by columns, translation. What is no pose is refused by the argument's name.
void read_target(const char* argument, nb::handle pose, double* to);
void bind_rollout(nb::module_& m, nb::class_<Controller>& c);
