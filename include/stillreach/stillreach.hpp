// The front door for C++: an arm and a controller that own their memory. Constructors check everything and throw; the
// loop neither allocates nor throws nor locks. With the CMake target stillreach::dispatch it runs the core for the
// processor at hand, without it the headers as they are compiled here.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "stillreach/memory.hpp"

STILLREACH_BEGIN
#if defined(STILLREACH_DISPATCH)
inline namespace dispatched {
#endif

constexpr double kNoLimit = HUGE_VAL;

/// A rigid transform, row-major 4 x 4; the identity at first.
struct Pose {
  double T[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  Pose() = default;
  Pose(double x, double y, double z) {
    T[3] = x;
    T[7] = y;
    T[11] = z;
  }
};

/// A joint: where its frame lies in the one before, and the axis about or along which it moves there.
struct Joint {
  Pose placement;
  double axis[3] = {0, 0, 1};  ///< of any length but 0
  JointKind kind = JointKind::REVOLUTE;
  double velocity_limit = kNoLimit;            ///< [rad/s, m/s], either way
  double lower = -kNoLimit, upper = kNoLimit;  ///< [rad, m]
  double acceleration_limit = kNoLimit;        ///< [rad/s2, m/s2]
  std::string name = {};
  /// The joint that it follows without a drive of its own, at multiplier times its position plus offset; its limits are
  /// those of that joint.
  std::string follows = {};
  double multiplier = 1.0, offset = 0.0;  ///< [], [rad, m]
};

/// Laws, with the numbers that docs/laws.md explains.
inline LawSettings least_error(double price = 80.0) {
  LawSettings law{};
  law.kind = LawKind::LEAST_ERROR;
  law.rank_tolerance = 1e-10;
  law.parts = 1;
  law.price[0] = price;
  return law;
}
inline LawSettings bare_least_error() {
  LawSettings law = least_error();
  law.parts = 0;
  return law;
}
inline LawSettings keep_direction() {
  LawSettings law = bare_least_error();
  law.kind = LawKind::KEEP_DIRECTION;
  return law;
}
inline LawSettings singularity_robust(DampingKind damping = DampingKind::EXACT, double kappa = 0.0) {
  LawSettings law = bare_least_error();
  law.kind = LawKind::SINGULARITY_ROBUST;
  law.damping = damping;
  law.kappa = kappa;
  return law;
}

/// What is wrong with a joint.
inline Fault locked() { return {Health::LOCKED, {0.0, 0.0}}; }
inline Fault derated(double fraction) { return {Health::DERATED, {fraction, 0.0}}; }
inline Fault runaway(double rate) { return {Health::RUNAWAY, {rate, 0.0}}; }
inline Fault confined(double lower, double upper) { return {Health::CONFINED, {lower, upper}}; }
inline Fault one_way(int direction) { return {Health::ONE_WAY, {direction < 0 ? -1.0 : 1.0, 0.0}}; }
inline Fault free_swinging() { return {Health::FREE_SWINGING, {0.0, 0.0}}; }

namespace front {

// Row-major 4 x 4, of rotation by columns and translation.
inline Pose row_major(const double* frame) {
  Pose at;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) at.T[4 * r + c] = frame[3 * c + r];
  return at;
}

inline std::string of_joint(std::size_t place, const Joint& joint) {
  return "joint " + std::to_string(place) + (joint.name.empty() ? "" : " (" + joint.name + ")");
}

}  // namespace front

/// A serial chain of joints with a tool. Immutable; copies share it.
class Arm {
 public:
  /// Throws std::invalid_argument with what check() says.
  explicit Arm(const std::vector<Joint>& joints, const Pose& tool = Pose())
      : joints_(with_drives(checked(joints, tool))), chain_(chain_of(joints, *joints_, tool)) {}

  /// What is wrong with the arguments of an arm; empty where nothing is.
  static std::string check(const std::vector<Joint>& joints, const Pose& tool = Pose()) {
    double pose[12];
    std::size_t followers = 0;
    if (!front::read_rigid(tool.T, pose)) return "the tool is no rigid transform (4 x 4, row-major)";
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const Joint& joint = joints[i];
      const std::string name = front::of_joint(i, joint);
      const double length = std::abs(joint.axis[0]) + std::abs(joint.axis[1]) + std::abs(joint.axis[2]);
      if (!front::read_rigid(joint.placement.T, pose))
        return name + ": its placement is no rigid transform (4 x 4, row-major)";
      if (!(length > 0.0 && length < HUGE_VAL)) return name + ": its axis has no direction";
      if (!(joint.velocity_limit >= 0.0)) return name + ": its velocity limit is below 0, or no number";
      if (!(joint.acceleration_limit >= 0.0)) return name + ": its acceleration limit is below 0, or no number";
      if (!(joint.lower <= joint.upper)) return name + ": its lower position limit is above the upper one";
      for (std::size_t k = 0; k < i; ++k)
        if (!joint.name.empty() && joints[k].name == joint.name) return name + ": another joint has that name";
      if (joint.follows.empty()) continue;
      ++followers;
      const int leader = place_of(joint.follows, joints);
      if (leader < 0 || !joints[static_cast<std::size_t>(leader)].follows.empty())
        return name + ": it follows " + joint.follows + ", which is no joint with a drive";
      if (!std::isfinite(joint.multiplier) || !std::isfinite(joint.offset))
        return name + ": its multiplier and offset are not finite";
    }
    if (joints.size() == followers) return "an arm needs at least one joint";
    return {};
  }

  /// Joints with a drive: those that follow others do not count.
  int n() const noexcept { return chain_.n(); }
  const Joint& joint(int i) const { return joints_->at(to_size(i)); }
  /// Index of a joint by its name, or -1.
  int index(const std::string& name) const noexcept { return place_of(name, *joints_); }
  const ArmView& view() const noexcept { return chain_.view(); }

  /// Pose of the tool at joint positions q (n). False, and nothing changes, where the size is wrong.
  bool kinematics(Span<const double> q, Pose& tool) const noexcept { return walk(q, tool, nullptr); }
  /// The same with the Jacobian (6 n), column after column: [v; w] of the tool along base axes by rate of the joint.
  bool kinematics(Span<const double> q, Pose& tool, Span<double> jacobian) const noexcept {
    return jacobian.size() == 6 * q.size() && walk(q, tool, jacobian.data());
  }

 private:
  static const std::vector<Joint>& checked(const std::vector<Joint>& joints, const Pose& tool) {
    const std::string wrong = check(joints, tool);
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    return joints;
  }
  static std::shared_ptr<const std::vector<Joint>> with_drives(const std::vector<Joint>& joints) {
    auto own = std::make_shared<std::vector<Joint>>();
    for (const Joint& joint : joints)
      if (joint.follows.empty()) own->push_back(joint);
    return own;
  }
  static ArmMemory chain_of(const std::vector<Joint>& joints, const std::vector<Joint>& own, const Pose& tool) {
    std::vector<double> placements, axes, factors, offsets;
    std::vector<JointKind> kinds;
    std::vector<int> leaders;
    int leading = 0;
    for (const Joint& joint : joints) {
      placements.insert(placements.end(), joint.placement.T, joint.placement.T + 16);
      const double length =
          std::sqrt(joint.axis[0] * joint.axis[0] + joint.axis[1] * joint.axis[1] + joint.axis[2] * joint.axis[2]);
      for (double a : joint.axis) axes.push_back(a / length);
      kinds.push_back(joint.kind);
      const bool leads = joint.follows.empty();
      leaders.push_back(leads ? leading++ : place_of(joint.follows, own));
      factors.push_back(leads ? 1.0 : joint.multiplier);
      offsets.push_back(leads ? 0.0 : joint.offset);
    }
    placements.insert(placements.end(), tool.T, tool.T + 16);
    if (joints.size() == own.size()) return {kinds, placements.data(), axes.data()};
    return {kinds, placements.data(), axes.data(), std::move(leaders), std::move(factors), std::move(offsets)};
  }

  static int place_of(const std::string& name, const std::vector<Joint>& joints) noexcept {
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (joints[i].name == name) return static_cast<int>(i);
    return -1;
  }

  bool walk(Span<const double> q, Pose& tool, double* jacobian) const noexcept {
    double frame[12];
    if (q.size() != to_size(n())) return false;
    chain_.kinematics(q.data(), frame, jacobian);
    tool = front::row_major(frame);
    return true;
  }

  std::shared_ptr<const std::vector<Joint>> joints_;  // n
  ArmMemory chain_;
};

/// Settings of a controller, as those of the Python package.
struct Options {
  LawSettings law = least_error();
  std::vector<int> rows = {0, 1, 2, 3, 4, 5};  ///< of [v; w], ascending
  bool tool_axes = false;                      ///< rows along the tool's axes
  double period = 0.001;                       ///< [s]
  double track_gain = 2.0;                     ///< [1/s]
  /// Largest correction [m/s], [rad/s]; below 0, both: the fastest that a working joint alone can move and turn the
  /// tool.
  double track_linear = -1.0, track_angular = -1.0;
  double return_rate = 0.0;      ///< [rad/s, m/s] at which joints outside their limits return
  double transition_rate = 2.0;  ///< [1/s] at which the null motion fades in after a fault
  NullMotionKind null_motion = NullMotionKind::NONE;
  double null_gain = 1.0, null_largest = kNoLimit;
  int null_failures = 1;                 ///< of TOLERANCE: how many joints are lost at once
  std::vector<double> null_vector = {};  ///< n: rates or posture, where the null motion needs one
};

/// The stateful tick. Its memory is made once, here.
class Controller {
 public:
  /// Throws std::invalid_argument with what check() says.
  explicit Controller(Arm arm, const Options& options = Options())
      : arm_(std::move(arm)), memory_(told(arm_, checked(arm_, options))), nothing_(to_size(arm_.n()), std::nan("")) {
    const Settings& s = memory_.state.settings;
    const auto write = [](const double* setting, int i, double value) {
      ControllerMemory::writable(setting)[i] = value;
    };
    for (int i = 0; i < arm_.n(); ++i) {
      const Joint& joint = arm_.joint(i);
      write(s.rate_lower, i, -joint.velocity_limit);
      write(s.rate_upper, i, joint.velocity_limit);
      write(s.position_lower, i, joint.lower);
      write(s.position_upper, i, joint.upper);
      write(s.acceleration, i, joint.acceleration_limit);
      if (!options.null_vector.empty()) write(s.null_vector, i, options.null_vector[to_size(i)]);
    }
    memory_.limits_changed();
  }

  /// What is wrong with the arguments of a controller; empty where nothing is.
  static std::string check(const Arm& arm, const Options& o) {
    const auto positive = [](double x) { return x > 0.0 && x < HUGE_VAL; };
    if (o.rows.empty() || o.rows.size() > 6) return "rows: 1 to 6 of [vx, vy, vz, wx, wy, wz], by index";
    for (std::size_t r = 0; r < o.rows.size(); ++r)
      if (o.rows[r] < 0 || o.rows[r] > 5 || (r > 0 && o.rows[r] <= o.rows[r - 1]))
        return "rows: ascending indices from 0 to 5";
    if (!positive(o.period)) return "period: a time above 0 s";
    if (!(o.track_gain >= 0.0 && o.track_gain < HUGE_VAL)) return "track_gain: at least 0 /s";
    if ((o.track_linear >= 0.0) != (o.track_angular >= 0.0) || std::isnan(o.track_linear + o.track_angular))
      return "track_linear, track_angular: both at least 0, or both below 0";
    if (!(o.return_rate >= 0.0 && o.return_rate < HUGE_VAL)) return "return_rate: at least 0";
    if (!(o.transition_rate >= 0.0 && o.transition_rate < HUGE_VAL)) return "transition_rate: at least 0 /s";
    if (o.null_motion == NullMotionKind::GRADIENT) return "null_motion: RATES with the gradient's rates at each tick";
    if (!(o.null_largest > 0.0)) return "null_largest: above 0";
    if (climbing(o.null_motion) && !positive(o.null_largest))
      return "null_largest: a finite rate, for this null motion";
    if (o.null_failures < 1 || o.null_failures > kMostFailures) return "null_failures: 1 to 8";
    const int m = static_cast<int>(o.rows.size());
    if (o.null_motion == NullMotionKind::TOLERANCE && choices(arm.n(), o.null_failures) > kMostChoices)
      return "null_failures: at most 5000 sets of so many joints";
    if (o.null_motion == NullMotionKind::GUARANTEED_SPEED && choices(arm.n(), m - 1) > kMostChoices)
      return "null_motion: GUARANTEED_SPEED for at most 5000 facets, as 16 joints have in 6 directions";
    if (!o.null_vector.empty() && o.null_vector.size() != to_size(arm.n()))
      return "null_vector: " + std::to_string(arm.n()) + " numbers";
    for (double x : o.null_vector)
      if (!std::isfinite(x)) return "null_vector: finite numbers";
    return {};
  }

  /// A tick: joint positions q (n), the twist [v; w] (6) of the tool along base axes, and room for rates (n). Returns
  /// the bits of Status; INVALID_INPUT, and rates that brake, for NaN and wrong sizes. All rates are 0 where their size
  /// is wrong. period: [s] for which these rates are held, where that changes from tick to tick; 0: the options'.
  std::int32_t step(Span<const double> q, Span<const double> twist, Span<double> rates, double period = 0.0) noexcept {
    return run(q, twist.size() == 6 ? twist.data() : nullptr, nullptr, rates, period);
  }

  /// The same, towards a pose of the task's point (16, row-major), with a twist as feedforward.
  std::int32_t track(Span<const double> q, Span<const double> target, Span<const double> twist, Span<double> rates,
                     double period = 0.0) noexcept {
    double pose[12];
    const bool right = target.size() == 16 && twist.size() == 6 && front::read_rigid(target.data(), pose);
    return run(q, right ? twist.data() : nullptr, right ? pose : nullptr, rates, period);
  }

  /// A joint fails, from the next tick on. False, and nothing changes, for a joint or a number that cannot be.
  bool fail(int joint, Fault fault = locked()) noexcept {
    if (joint < 0 || joint >= arm_.n() || !possible(fault)) return false;
    memory_.set_fault(joint, fault);
    return true;
  }
  bool restore(int joint) noexcept { return fail(joint, Fault{}); }

  /// Other velocity limits from the next tick on (n, at least 0); rates come down within the acceleration limits.
  /// False, and nothing changes, where they are not that.
  bool set_velocity_limits(Span<const double> limits) noexcept {
    const std::size_t count = to_size(arm_.n());
    if (limits.size() != count) return false;
    for (std::size_t i = 0; i < count; ++i)
      if (!(limits.data()[i] >= 0.0)) return false;
    const Settings& s = memory_.state.settings;
    for (std::size_t i = 0; i < count; ++i) {
      ControllerMemory::writable(s.rate_lower)[i] = -limits.data()[i];
      ControllerMemory::writable(s.rate_upper)[i] = limits.data()[i];
    }
    memory_.limits_changed(CLOSING_RATE);
    return true;
  }

  /// The arm stands still: the next tick knows of no rates before. Faults stay.
  void reset() noexcept { memory_.reset(); }
  /// The same for an arm that moves, at measured rates (n). False, and nothing changes, where they are not that.
  bool reset(Span<const double> rates) noexcept {
    if (rates.size() != to_size(arm_.n())) return false;
    for (std::size_t i = 0; i < rates.size(); ++i)
      if (!std::isfinite(rates.data()[i])) return false;
    memory_.reset(rates.data());
    return true;
  }

  const Arm& arm() const noexcept { return arm_; }
  Health health(int joint) const {
    return joint < 0 || joint >= arm_.n() ? throw std::out_of_range("no such joint") : state().faults.of[joint].health;
  }
  /// Of the last tick: pose of the task's point (16, row-major), bounds (n), residual of the task (m), its norm.
  Pose pose() const noexcept { return front::row_major(state().now.pose); }
  Span<const double> lower() const noexcept { return {state().now.bounds.lower, to_size(arm_.n())}; }
  Span<const double> upper() const noexcept { return {state().now.bounds.upper, to_size(arm_.n())}; }
  Span<const double> residual() const noexcept { return {memory_.answer.residual, to_size(state().settings.m)}; }
  double task_error() const noexcept { return memory_.answer.task_error; }
  /// All that it was told and remembers, and the whole answer of the last tick.
  const ControllerState& state() const noexcept { return memory_.state; }
  const Answer& answer() const noexcept { return memory_.answer; }

 private:
  std::int32_t run(Span<const double> q, const double* twist, const double* pose, Span<double> rates,
                   double period) noexcept {
    static const double still[6] = {0, 0, 0, 0, 0, 0};
    const std::size_t count = to_size(arm_.n());
    if (rates.size() != count) {
      std::fill_n(rates.data(), rates.size(), 0.0);
      return INVALID_INPUT;
    }
    const bool right = twist && q.size() == count && period >= 0.0 && period < HUGE_VAL;
    if (right)
      memory_.tick(q.data(), twist, pose, period);
    else
      memory_.tick(nothing_.data(), still);
    std::copy_n(memory_.answer.rates, count, rates.data());
    return memory_.answer.status;
  }

  static const Options& checked(const Arm& arm, const Options& options) {
    const std::string wrong = check(arm, options);
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    return options;
  }
  static Settings told(const Arm& arm, const Options& o) {
    Settings s{};
    s.arm = arm.view();
    s.law = o.law;
    s.m = static_cast<int>(o.rows.size());
    for (int r = 0; r < s.m; ++r) s.rows[r] = o.rows[to_size(r)];
    s.tool_axes = o.tool_axes;
    s.every_row = s.m == 6 && !o.tool_axes;
    s.period = o.period;
    s.return_rate = o.return_rate;
    s.transition_rate = o.transition_rate;
    s.track_gain = o.track_gain;
    s.track_automatic = o.track_linear < 0.0;
    s.track_linear = o.track_linear;
    s.track_angular = o.track_angular;
    s.null_kind = o.null_motion;
    s.null_gain = o.null_gain;
    s.null_largest = o.null_largest;
    s.null_failures = o.null_failures;
    return s;
  }

  Arm arm_;
  ControllerMemory memory_;
  std::vector<double> nothing_;  // n: NaN
};

#if defined(STILLREACH_DISPATCH)
}  // namespace dispatched
#endif
STILLREACH_END
