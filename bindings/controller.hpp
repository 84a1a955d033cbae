// The controller's memory, and its tick as Python calls it.
#pragma once

#include "solution.hpp"

struct Controller {
  Arm arm;
  std::shared_ptr<const MetricData> metric;
  stillreach::ControllerState state{};
  Scratch scratch;
  std::vector<double> numbers;       // everything that `state` points to
  std::vector<std::int8_t> bytes;
  std::vector<double> rates, residual, measured;
  std::vector<std::int8_t> active;
  stillreach::Answer answer{};
  nb::object gradient;               // a callable q -> (n,), or none
  nb::object labels;                 // _door.Labels of the joints

  int n() const { return state.arm.n; }
  // period: [s] of this tick alone, 0 for the controller's own.
  void run(const double* q, const double* twist, const double* target, double period) {
    const double own = state.period;
    if (period > 0.0) state.period = period, state.uneven = 1;
    kernel().tick(state, q, twist, target, scratch.memory(), answer);
    state.period = own, state.uneven = 0;
  }
  // Evaluates the user's gradient at q. False, with the null motion off for this tick, where it failed.
  bool update_gradient(const double* q, bool raise);
};

void bind_rollout(nb::class_<Controller>& c);
