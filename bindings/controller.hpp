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

  int n() const { return state.arm.n; }
  void run(const double* q, const double* twist, const double* target) {
    kernel().tick(state, q, twist, target, scratch.memory(), answer);
  }
  // Evaluates the user's gradient at q. False, with the null motion off for this tick, where it failed.
  bool update_gradient(const double* q, bool raise);
};

// Row-major 4 x 4 pose to rotation by columns and translation. False: not a finite pose with a rotation in it.
bool read_pose(const double* matrix, double* frame);

void bind_rollout(nb::class_<Controller>& c);
