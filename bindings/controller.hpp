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
  stillreach::ControllerMemory core;
  nb::object labels;                       // _door.Labels of the joints
  std::vector<double> measured, proposed;  // leased to one call at a time
  std::int64_t ticks = 0;                  // so far
  nb::object gradient;                     // the null motion's, evaluated before each tick; invalid without one
  std::unique_ptr<NullMotion> next;        // the null motion from the next tick on, where it was set since the last one

  // told: settings of the arm and the metric given.
  Controller(Arm chain, std::shared_ptr<const MetricData> weights, const stillreach::Settings& told, nb::handle names)
      : arm(std::move(chain)), metric(std::move(weights)), core(told), labels(nb::borrow(names)) {}
  int n() const { return core.n(); }
  stillreach::Settings& settings() { return core.state.settings; }
  // period: [s] of this tick alone, 0 for the controller's own.
  void run(const double* q, const double* twist, const double* target, double period) {
    core.tick(q, twist, target, period);
    ++ticks;
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
void bind_bound_tick(nb::module_& m, nb::class_<Controller>& c);
