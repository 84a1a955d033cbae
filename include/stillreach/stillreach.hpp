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

#if defined(STILLREACH_DISPATCH)
#include "stillreach/dispatch.hpp"
#else
#include "stillreach/control/controller.hpp"
#include "stillreach/kinematics/arm.hpp"
#include "stillreach/kinematics/coupled.hpp"
#endif

STILLREACH_BEGIN
#if defined(STILLREACH_DISPATCH)
inline namespace dispatched {  // other code than without it: one program may hold both
#endif

constexpr double kNoLimit = HUGE_VAL;

/// Numbers in a row that the caller owns.
template <class T>
class Span {
 public:
  constexpr Span(T* data, std::size_t size) noexcept : data_(data), size_(size) {}
  template <std::size_t N>
  constexpr Span(T (&array)[N]) noexcept : data_(array), size_(N) {}
  template <class Container, class = decltype(std::declval<Container&>().data())>
  constexpr Span(Container&& all) noexcept : data_(all.data()), size_(all.size()) {}
  constexpr T* data() const noexcept { return data_; }
  constexpr std::size_t size() const noexcept { return size_; }

 private:
  T* data_;
  std::size_t size_;
};

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

// The core behind the door.
#if defined(STILLREACH_DISPATCH)
inline bool read_rigid(const double* T, double* pose) { return kernel().read_pose(T, pose); }
inline void choose_correction(ControllerState& s) { kernel().bound_correction(s); }
inline std::size_t doubles(int n) { return kernel().workspace_doubles(n, false); }
inline std::size_t ints(int n) { return kernel().workspace_ints(n); }
inline std::size_t bytes(int n) { return kernel().workspace_bytes(n); }
inline ArmView aligned(int n, const JointKind* kinds, const double* placements, const double* axes, Link* links) {
  return kernel().align_axes(n, kinds, placements, axes, links);
}
inline void walk(const ArmView& coupled, const double* q, double* pose, double* jacobian) {
  kernel().kinematics(coupled, q, nullptr, pose, jacobian);
}
#else
inline bool read_rigid(const double* T, double* pose) { return read_pose(T, pose); }
inline void choose_correction(ControllerState& s) { bound_correction(s); }
inline std::size_t doubles(int n) { return workspace_doubles(n, false); }
inline std::size_t ints(int n) { return workspace_ints(n); }
inline std::size_t bytes(int n) { return workspace_bytes(n); }
inline ArmView aligned(int n, const JointKind* kinds, const double* placements, const double* axes, Link* links) {
  return align_axes(n, kinds, placements, axes, links);
}
inline void walk(const ArmView& coupled, const double* q, double* pose, double* jacobian) {
  coupled_kinematics(coupled, q, pose, jacobian);
}
#endif

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
  explicit Arm(std::vector<Joint> joints, const Pose& tool = Pose()) {
    const std::string wrong = check(joints, tool);
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    auto made = std::make_shared<Made>();
    std::vector<double> placements, axes;
    std::vector<JointKind> kinds;
    for (const Joint& joint : joints) {
      placements.insert(placements.end(), joint.placement.T, joint.placement.T + 16);
      const double length =
          std::sqrt(joint.axis[0] * joint.axis[0] + joint.axis[1] * joint.axis[1] + joint.axis[2] * joint.axis[2]);
      for (double a : joint.axis) axes.push_back(a / length);
      kinds.push_back(joint.kind);
    }
    placements.insert(placements.end(), tool.T, tool.T + 16);
    for (const Joint& joint : joints)
      if (joint.follows.empty()) made->joints.push_back(joint);
    for (std::size_t i = 0, own = 0; i < joints.size(); ++i) {
      const Joint& joint = joints[i];
      const bool leads = joint.follows.empty();
      made->leaders.push_back(leads ? static_cast<int>(own++) : place_of(joint.follows, made->joints));
      made->factors.push_back(leads ? 1.0 : joint.multiplier);
      made->offsets.push_back(leads ? 0.0 : joint.offset);
    }
    made->links.resize(joints.size());
    made->view = front::aligned(static_cast<int>(joints.size()), kinds.data(), placements.data(), axes.data(),
                                made->links.data());
    made->view.n = static_cast<int>(made->joints.size());
    made->coupling = {static_cast<int>(joints.size()), made->leaders.data(), made->factors.data(),
                      made->offsets.data()};
    made->walked = made->view;
    made->walked.coupling = &made->coupling;
    if (joints.size() > made->joints.size()) made->view = made->walked;
    made_ = std::move(made);
  }

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
  int n() const noexcept { return made_->view.n; }
  const Joint& joint(int i) const { return made_->joints.at(static_cast<std::size_t>(i)); }
  /// Index of a joint by its name, or -1.
  int index(const std::string& name) const noexcept { return place_of(name, made_->joints); }
  const ArmView& view() const noexcept { return made_->view; }

  /// Pose of the tool at joint positions q (n). False, and nothing changes, where the size is wrong.
  bool kinematics(Span<const double> q, Pose& tool) const noexcept { return walk(q, tool, nullptr); }
  /// The same with the Jacobian (6 n), column after column: [v; w] of the tool along base axes by rate of the joint.
  bool kinematics(Span<const double> q, Pose& tool, Span<double> jacobian) const noexcept {
    return jacobian.size() == 6 * q.size() && walk(q, tool, jacobian.data());
  }

 private:
  struct Made {
    std::vector<Joint> joints;  // n
    std::vector<Link> links;    // of the chain, and whom its joints follow
    std::vector<int> leaders;
    std::vector<double> factors, offsets;
    Coupling coupling;
    ArmView view;
    ArmView walked;  // along the chain, which takes no memory
  };

  static int place_of(const std::string& name, const std::vector<Joint>& joints) noexcept {
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (joints[i].name == name) return static_cast<int>(i);
    return -1;
  }

  bool walk(Span<const double> q, Pose& tool, double* jacobian) const noexcept {
    double frame[12];
    if (q.size() != to_size(n())) return false;
    front::walk(made_->walked, q.data(), frame, jacobian);
    tool = front::row_major(frame);
    return true;
  }
  std::shared_ptr<const Made> made_;
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
  explicit Controller(Arm arm, Options options = Options()) : arm_(std::move(arm)), options_(std::move(options)) {
    const std::string wrong = check(arm_, options_);
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    const int n = arm_.n();
    const std::size_t count = to_size(n);
    numbers_.assign(to_size(kStateNumbers) * count, 0.0);
    small_.assign(to_size(kStateBytes) * count, 0);
    active_.assign(count, 0);
    rates_.assign(count, 0.0);
    faults_.assign(count, Fault{});
    doubles_.assign(front::doubles(n), 0.0);
    ints_.assign(front::ints(n), 0);
    bytes_.assign(front::bytes(n), 0);
    ControllerState& s = state_;
    s.arm = arm_.view();
    s.law = options_.law;
    s.m = static_cast<int>(options_.rows.size());
    for (int r = 0; r < s.m; ++r) s.rows[r] = options_.rows[to_size(r)];
    s.tool_axes = options_.tool_axes;
    s.every_row = s.m == 6 && !options_.tool_axes;
    s.constant_bounds = 1;
    s.period = options_.period;
    s.return_rate = options_.return_rate;
    s.transition_rate = options_.transition_rate;
    s.track_gain = options_.track_gain;
    s.track_automatic = options_.track_linear < 0.0;
    s.track_linear = options_.track_linear;
    s.track_angular = options_.track_angular;
    s.null_kind = options_.null_motion;
    s.null_gain = options_.null_gain;
    s.null_largest = options_.null_largest;
    s.null_failures = options_.null_failures;
    point_into(s, numbers_.data(), small_.data());
    double *lower = numbers_.data(), *upper = lower + count, *first = upper + count, *last = first + count;
    double *acceleration = last + count, *vector = acceleration + count;
    for (std::size_t i = 0; i < count; ++i) {
      const Joint& joint = arm_.joint(static_cast<int>(i));
      lower[i] = -joint.velocity_limit;
      upper[i] = joint.velocity_limit;
      first[i] = joint.lower;
      last[i] = joint.upper;
      acceleration[i] = joint.acceleration_limit;
      if (!options_.null_vector.empty()) vector[i] = options_.null_vector[i];
      const bool endless = joint.lower == -kNoLimit && joint.upper == kNoLimit && joint.acceleration_limit == kNoLimit;
      s.constant_bounds = s.constant_bounds && endless;
    }
    s.faults = faults_.data();
    front::choose_correction(s);
    nothing_.assign(count, std::nan(""));
    answer_.rates = rates_.data();
    answer_.residual = residual_.data();
    answer_.active = active_.data();
  }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  Controller(Controller&&) = default;  // what the state points to is on the heap, and stays there
  Controller& operator=(Controller&&) = default;

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
  /// is wrong.
  std::int32_t step(Span<const double> q, Span<const double> twist, Span<double> rates) noexcept {
    return run(q, twist.size() == 6 ? twist.data() : nullptr, nullptr, rates);
  }

  /// The same, towards a pose of the task's point (16, row-major), with a twist as feedforward.
  std::int32_t track(Span<const double> q, Span<const double> target, Span<const double> twist,
                     Span<double> rates) noexcept {
    double pose[12];
    const bool right = target.size() == 16 && twist.size() == 6 && front::read_rigid(target.data(), pose);
    return run(q, right ? twist.data() : nullptr, right ? pose : nullptr, rates);
  }

  /// A joint fails, from the next tick on. False, and nothing changes, for a joint or a number that cannot be.
  bool fail(int joint, Fault fault = locked()) noexcept {
    if (joint < 0 || joint >= arm_.n() || std::isnan(fault.number[0]) || std::isnan(fault.number[1])) return false;
    const double a = fault.number[0], b = fault.number[1];
    if (fault.health == Health::DERATED && !(a >= 0.0 && a <= 1.0)) return false;
    if (fault.health == Health::RUNAWAY && std::isinf(a)) return false;
    if (fault.health == Health::CONFINED && !(a <= b)) return false;
    tell(joint, fault);
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
    for (std::size_t i = 0; i < count; ++i) {
      numbers_[i] = -limits.data()[i];
      numbers_[count + i] = limits.data()[i];
      state_.closing[i] = static_cast<std::int8_t>(state_.closing[i] | CLOSING_RATE);
    }
    state_.bounds_stand = 0;
    front::choose_correction(state_);
    return true;
  }

  /// The arm stands still: the next tick knows of no rates before. Faults stay.
  void reset() noexcept {
    std::fill_n(state_.last, arm_.n(), 0.0);
    std::fill_n(state_.anchor, arm_.n(), 0.0);
    state_.transition = 0.0;
  }
  /// The same for an arm that moves, at measured rates (n). False, and nothing changes, where they are not that.
  bool reset(Span<const double> rates) noexcept {
    if (rates.size() != to_size(arm_.n())) return false;
    for (std::size_t i = 0; i < rates.size(); ++i)
      if (!std::isfinite(rates.data()[i])) return false;
    reset();
    std::copy_n(rates.data(), rates.size(), state_.last);
    return true;
  }

  const Arm& arm() const noexcept { return arm_; }
  Health health(int joint) const { return faults_.at(to_size(joint)).health; }
  /// Of the last tick: pose of the task's point (16, row-major), bounds (n), residual of the task (m), its norm.
  Pose pose() const noexcept { return front::row_major(state_.pose); }
  Span<const double> lower() const noexcept { return {state_.lower, to_size(arm_.n())}; }
  Span<const double> upper() const noexcept { return {state_.upper, to_size(arm_.n())}; }
  Span<const double> residual() const noexcept { return {residual_.data(), to_size(state_.m)}; }
  double task_error() const noexcept { return answer_.task_error; }

 private:
  std::int32_t run(Span<const double> q, const double* twist, const double* pose, Span<double> rates) noexcept {
    static const double still[6] = {0, 0, 0, 0, 0, 0};
    const std::size_t count = to_size(arm_.n());
    if (rates.size() != count) {
      std::fill_n(rates.data(), rates.size(), 0.0);
      return INVALID_INPUT;
    }
    const bool right = twist && q.size() == count;
    go(right ? q.data() : nothing_.data(), right ? twist : still, right ? pose : nullptr);
    std::copy_n(rates_.data(), count, rates.data());
    return answer_.status;
  }
#if defined(STILLREACH_DISPATCH)
  void go(const double* q, const double* twist, const double* pose) noexcept {
    kernel().tick(state_, q, twist, pose, {doubles_.data(), ints_.data(), bytes_.data()}, answer_);
  }
  void tell(int joint, const Fault& fault) noexcept { kernel().set_fault(state_, joint, fault); }
#else
  void go(const double* q, const double* twist, const double* pose) noexcept {
    Workspace w = make_workspace(arm_.n(), false, doubles_.data(), ints_.data(), bytes_.data());
    tick(state_, q, twist, pose, w, answer_);
  }
  void tell(int joint, const Fault& fault) noexcept { set_fault(state_, joint, fault); }
#endif

  Arm arm_;
  Options options_;
  std::vector<double> numbers_, rates_, doubles_, nothing_;  // the last one NaN
  std::vector<double> residual_ = std::vector<double>(6, 0.0);
  std::vector<std::int8_t> small_, active_, bytes_;
  std::vector<int> ints_;
  std::vector<Fault> faults_;
  ControllerState state_{};
  Answer answer_{};
};

#if defined(STILLREACH_DISPATCH)
}  // namespace dispatched
#endif
STILLREACH_END
