// A robot's own C++ loop: owns the memory of a controller and of the core's workspace, every buffer exactly as long as
// the headers ask for, so that the address sanitizer sees the first number written behind one.
#pragma once

#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "chains.hpp"
#include "stillreach/dispatch.hpp"
#include "stillreach/problem/workspace.hpp"

using stillreach::kernel;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Scratch memory for n joints, as Kernel::solve, tick and rollout want it.
struct Scratch {
  std::vector<double> doubles;
  std::vector<int> ints;
  std::vector<std::int8_t> bytes;
  Scratch(int n, bool full_joint_weight)
      : doubles(kernel().workspace_doubles(n, full_joint_weight), -7e77),
        ints(stillreach::workspace_ints(n), 123456789),
        bytes(stillreach::workspace_bytes(n), 77) {}
  stillreach::Memory memory() { return {doubles.data(), ints.data(), bytes.data()}; }
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
  int n, m;
  std::vector<stillreach::Link> links;
  std::vector<double> rate_lower, rate_upper, position_lower, position_upper, acceleration, null_vector, last, anchor;
  std::vector<stillreach::Fault> faults;
  std::vector<double> jacobian, selected, lower, upper, reference, kinematics_scratch, units, weight;
  std::vector<std::int8_t> warm, lower_reason, upper_reason;
  std::vector<double> rates, residual;
  std::vector<std::int8_t> active;
  Scratch scratch;
  stillreach::ControllerState state{};
  stillreach::Answer answer{};

  Robot(const Chain& chain, const stillreach::LawSettings& law, const Options& o = {})
      : n(chain.n()),
        m(static_cast<int>(o.rows.size())),
        links(n),
        rate_lower(n, -o.rate),
        rate_upper(n, o.rate),
        position_lower(n, -o.position),
        position_upper(n, o.position),
        acceleration(n, o.acceleration),
        null_vector(n, 0.25),
        last(n),
        anchor(n),
        faults(n),
        jacobian(6 * n),
        selected(m * n),
        lower(n),
        upper(n),
        reference(n),
        kinematics_scratch(10 * n),
        warm(n),
        lower_reason(n),
        upper_reason(n),
        rates(n),
        residual(m),
        active(n),
        scratch(n, o.joint_matrix) {
    state.arm = kernel().align_axes(n, chain.kinds.data(), chain.placements.data(), chain.axes.data(), links.data());
    if (o.joint_matrix) {
      units.assign(n, 1.0);
      weight = coupling_matrix(n);
    }
    tell(law, o);
    point();
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void tell(const stillreach::LawSettings& law, const Options& o) {
    stillreach::ControllerState& s = state;
    s.law = law;
    s.m = m;
    s.tool_axes = o.tool_axes;
    s.every_row = m == 6 && !o.tool_axes;
    for (int r = 0; r < m; ++r) s.rows[r] = o.rows[r];
    s.constant_bounds = o.position == kInfinity && o.acceleration == kInfinity;
    s.period = o.period;
    s.transition_rate = o.transition_rate;
    s.track_gain = 2.0;
    s.track_linear = s.track_angular = kInfinity;
    s.null_kind = o.null_kind;
    s.null_failures = o.null_failures;
    s.null_gain = 0.5;
    s.null_largest = 0.5;
  }

  void point() {
    stillreach::ControllerState& s = state;
    if (!weight.empty()) s.metric = {nullptr, units.data(), units.data(), weight.data()};
    s.rate_lower = rate_lower.data();
    s.rate_upper = rate_upper.data();
    s.position_lower = position_lower.data();
    s.position_upper = position_upper.data();
    s.acceleration = acceleration.data();
    s.null_vector = null_vector.data();
    s.faults = faults.data();
    s.last = last.data();
    s.anchor = anchor.data();
    s.active = warm.data();
    s.jacobian = jacobian.data();
    s.task_jacobian = s.every_row ? jacobian.data() : selected.data();
    s.lower = lower.data();
    s.upper = upper.data();
    s.lower_reason = lower_reason.data();
    s.upper_reason = upper_reason.data();
    s.reference = reference.data();
    s.scratch = kinematics_scratch.data();
    answer.rates = rates.data();
    answer.residual = residual.data();
    answer.active = active.data();
  }

  void fail(int joint, stillreach::Health kind = stillreach::Health::LOCKED, double first = 0.0, double second = 0.0) {
    kernel().set_fault(state, joint, {kind, {first, second}});
  }
  void restore(int joint) { fail(joint, stillreach::Health::HEALTHY); }

  std::int32_t tick(const double* q, const double* twist, const double* target = nullptr) {
    kernel().tick(state, q, twist, target, scratch.memory(), answer);
    return answer.status;
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
