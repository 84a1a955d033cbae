// A robot's own C++ loop over the memory of stillreach/memory.hpp, every buffer exactly as long as the headers ask for,
// so that the address sanitizer sees the first number written behind one.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "chains.hpp"
#include "stillreach/dispatch.hpp"
#include "stillreach/problem/workspace.hpp"

using stillreach::kernel;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The core's memory for one solve, full of rubbish.
struct Scratch : stillreach::WorkspaceMemory {
  Scratch(int n, bool full_joint_weight) : WorkspaceMemory(n, full_joint_weight) {
    const stillreach::Memory to = view();
    std::fill_n(to.doubles, kernel().workspace_doubles(n, full_joint_weight), -7e77);
    std::fill_n(to.ints, kernel().workspace_ints(n), 123456789);
    std::fill_n(to.bytes, kernel().workspace_bytes(n), std::int8_t{77});
  }
};

struct Options {
  std::vector<int> rows = {0, 1, 2, 3, 4, 5};
  bool tool_axes = false;
  double rate = 1.0;
  double position = kInfinity;
  double acceleration = kInfinity;
  double period = 0.001;
  double transition_rate = 0.0;
  stillreach::NullMotionKind null_kind = stillreach::NullMotionKind::NONE;
  int null_failures = 1;
  bool joint_matrix = false;  // a full joint weight: tridiagonal, positive definite
};

inline stillreach::LawSettings law_settings(stillreach::LawKind kind,
                                            stillreach::DampingKind damping = stillreach::DampingKind::NUMBER,
                                            stillreach::NormKind norm = stillreach::NormKind::MAXIMUM,
                                            double kappa = 0.0, double price = 0.0) {
  return {kind, damping, norm, kappa, 1e-10, price > 0.0, {}, {price}, -1, 0.0, 0.0};
}

struct NamedLaw {
  const char* name;
  stillreach::LawSettings settings;
  bool inside;  // promises rates inside the bounds
};

inline std::vector<NamedLaw> every_law() {
  using namespace stillreach;
  return {{"pseudoinverse", law_settings(LawKind::PSEUDOINVERSE), false},
          {"number", law_settings(LawKind::SINGULARITY_ROBUST, DampingKind::NUMBER, NormKind::MAXIMUM, 1e-3), true},
          {"closed form", law_settings(LawKind::SINGULARITY_ROBUST, DampingKind::CLOSED_FORM, NormKind::MAXIMUM), true},
          {"closed form, 2-norm",
           law_settings(LawKind::SINGULARITY_ROBUST, DampingKind::CLOSED_FORM, NormKind::EUCLIDEAN), true},
          {"exact", law_settings(LawKind::SINGULARITY_ROBUST, DampingKind::EXACT, NormKind::MAXIMUM), true},
          {"exact, 2-norm", law_settings(LawKind::SINGULARITY_ROBUST, DampingKind::EXACT, NormKind::EUCLIDEAN), true},
          {"least error", law_settings(LawKind::LEAST_ERROR, DampingKind::NUMBER, NormKind::MAXIMUM, 0.0, 80.0), true},
          {"bare least error", law_settings(LawKind::LEAST_ERROR), true},
          {"keep direction", law_settings(LawKind::KEEP_DIRECTION), true}};
}

// Identity plus a coupling of neighbours; its eigenvalues lie between 0.2 and 1.8.
inline std::vector<double> coupling_matrix(int n) {
  std::vector<double> W(static_cast<std::size_t>(n) * n, 0.0);
  for (int i = 0; i < n; ++i) {
    W[static_cast<std::size_t>(i) * n + i] = 1.0;
    if (i > 0) W[static_cast<std::size_t>(i) * n + i - 1] = W[static_cast<std::size_t>(i - 1) * n + i] = 0.4;
  }
  return W;
}

struct Robot {
  template <class T>
  using Span = stillreach::Span<T>;

  stillreach::ArmMemory arm;
  std::vector<double> units, weight;
  stillreach::ControllerMemory core;
  stillreach::ControllerState& state = core.state;
  stillreach::Answer& answer = core.answer;
  const int n = core.n(), m = state.settings.m;
  const Span<double> rates = of(answer.rates), residual{answer.residual, stillreach::to_size(m)};
  const Span<std::int8_t> active = of(answer.active);
  const Span<stillreach::Fault> faults = of(state.faults.of);
  const Span<double> last = of(state.last.rates), lower = of(state.now.bounds.lower),
                     upper = of(state.now.bounds.upper);
  const Span<std::int8_t> lower_reason = of(state.now.bounds.lower_reason);
  const Span<double> jacobian{state.now.jacobian, stillreach::to_size(6 * n)}, reference = of(state.now.reference);

  Robot(const Chain& chain, const stillreach::LawSettings& law, const Options& o = {})
      : arm(chain.arm()),
        units(o.joint_matrix ? chain.n() : 0, 1.0),
        weight(o.joint_matrix ? coupling_matrix(chain.n()) : units),
        core(told(law, o)) {
    core.workspace = Scratch(n, o.joint_matrix);
    const stillreach::Settings& s = state.settings;
    fill(s.rate_lower, -o.rate);
    fill(s.rate_upper, o.rate);
    fill(s.position_lower, -o.position);
    fill(s.position_upper, o.position);
    fill(s.acceleration, o.acceleration);
    fill(s.null_vector, 0.25);
    core.limits_changed();
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  stillreach::Settings told(const stillreach::LawSettings& law, const Options& o) const {
    stillreach::Settings s{};
    s.arm = arm.view();
    s.law = law;
    if (o.joint_matrix) s.metric = {nullptr, units.data(), units.data(), weight.data()};
    s.m = static_cast<int>(o.rows.size());
    s.tool_axes = o.tool_axes;
    s.every_row = s.m == 6 && !o.tool_axes;
    for (int r = 0; r < s.m; ++r) s.rows[r] = o.rows[r];
    s.period = o.period;
    s.transition_rate = o.transition_rate;
    s.track_gain = 2.0;
    s.track_linear = s.track_angular = kInfinity;
    s.null_kind = o.null_kind;
    s.null_failures = o.null_failures;
    s.null_gain = 0.5;
    s.null_largest = 0.5;
    return s;
  }

  template <class T>
  Span<T> of(T* all) const {
    return {all, stillreach::to_size(n)};
  }
  void fill(const double* setting, double value) {
    std::fill_n(stillreach::ControllerMemory::writable(setting), n, value);
  }

  void fail(int joint, stillreach::Health kind = stillreach::Health::LOCKED, double first = 0.0, double second = 0.0) {
    core.set_fault(joint, {kind, {first, second}});
  }
  void restore(int joint) { fail(joint, stillreach::Health::HEALTHY); }

  std::int32_t tick(const double* q, const double* twist, const double* target = nullptr) {
    return core.tick(q, twist, target);
  }

  bool finite() const {
    for (double r : rates)
      if (!std::isfinite(r)) return false;
    return true;
  }
  bool inside() const {
    for (int i = 0; i < n; ++i)
      if (!(rates[i] >= lower[i] && rates[i] <= upper[i])) return false;
    return true;
  }
  // Exactly at their rates: 0 for locked joints, its own for a runaway one.
  bool failed_joints_keep_their_rates() const {
    for (int i = 0; i < n; ++i) {
      if (faults[i].health == stillreach::Health::LOCKED && rates[i] != 0.0) return false;
      if (faults[i].health == stillreach::Health::RUNAWAY && rates[i] != faults[i].number[0]) return false;
    }
    return true;
  }
};
