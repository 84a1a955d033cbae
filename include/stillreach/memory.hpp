// Owners of the memory that the core works in: made once, each array of its own and exactly as long as the core asks
// for. The front door (stillreach.hpp) stands on them. With the CMake target stillreach::dispatch they call the core
// for the processor at hand, without it the headers as they are compiled here.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
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

namespace front {

// The core behind the door.
#if defined(STILLREACH_DISPATCH)
inline bool read_rigid(const double* T, double* pose) { return kernel().read_pose(T, pose); }
inline std::size_t doubles(int n, bool full) { return kernel().workspace_doubles(n, full); }
inline std::size_t ints(int n) { return kernel().workspace_ints(n); }
inline std::size_t bytes(int n) { return kernel().workspace_bytes(n); }
inline ArmView aligned(int n, const JointKind* kinds, const double* placements, const double* axes, Link* links) {
  return kernel().align_axes(n, kinds, placements, axes, links);
}
inline void walk(const ArmView& coupled, const double* q, double* pose, double* jacobian) {
  kernel().kinematics(coupled, q, nullptr, pose, jacobian);
}
inline void choose_correction(ControllerState& c) noexcept { kernel().bound_correction(c); }
inline void tell(ControllerState& c, int joint, const Fault& fault) noexcept { kernel().set_fault(c, joint, fault); }
inline void run(ControllerState& c, const double* q, const double* twist, const double* target, const Memory& memory,
                Answer& answer) noexcept {
  kernel().tick(c, q, twist, target, memory, answer);
}
#else
inline bool read_rigid(const double* T, double* pose) { return read_pose(T, pose); }
inline std::size_t doubles(int n, bool full) { return workspace_doubles(n, full); }
inline std::size_t ints(int n) { return workspace_ints(n); }
inline std::size_t bytes(int n) { return workspace_bytes(n); }
inline ArmView aligned(int n, const JointKind* kinds, const double* placements, const double* axes, Link* links) {
  return align_axes(n, kinds, placements, axes, links);
}
inline void walk(const ArmView& coupled, const double* q, double* pose, double* jacobian) {
  coupled_kinematics(coupled, q, pose, jacobian);
}
inline void choose_correction(ControllerState& c) noexcept { bound_correction(c.settings, c.faults, c.now.scratch); }
inline void tell(ControllerState& c, int joint, const Fault& fault) noexcept { set_fault(c, joint, fault); }
inline void run(ControllerState& c, const double* q, const double* twist, const double* target, const Memory& memory,
                Answer& answer) noexcept {
  Workspace w = make_workspace(c.settings.arm.n, c.settings.metric.joints != nullptr, memory);
  tick(c, q, twist, target, w, answer);
}
#endif

}  // namespace front

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
  constexpr T* begin() const noexcept { return data_; }
  constexpr T* end() const noexcept { return data_ + size_; }
  template <class Index>
  constexpr T& operator[](Index i) const noexcept {
    return data_[i];
  }

 private:
  T* data_;
  std::size_t size_;
};

/// A chain of joints as the core reads it. Checks nothing; immutable, and copies share it.
class ArmMemory {
 public:
  /// Of each joint of the chain its kind, its placement (16, row-major) in the frame before it and its axis (3, of
  /// length 1); one placement more, the tool's. leaders, factors and offsets are those of Coupling; empty: no joint
  /// follows another.
  ArmMemory(const std::vector<JointKind>& kinds, const double* placements, const double* axes,
            std::vector<int> leaders = {}, std::vector<double> factors = {}, std::vector<double> offsets = {}) {
    const int moved = static_cast<int>(kinds.size());
    const bool follow = !leaders.empty();
    auto made = std::make_shared<Made>();
    made->links.resize(kinds.size());
    made->leaders = std::move(leaders);
    made->factors = std::move(factors);
    made->offsets = std::move(offsets);
    for (int a = 0; a < moved && !follow; ++a) made->leaders.push_back(a);
    made->factors.resize(kinds.size(), 1.0);
    made->offsets.resize(kinds.size(), 0.0);
    made->view = front::aligned(moved, kinds.data(), placements, axes, made->links.data());
    made->view.links = made->links.data();
    made->view.n = 0;
    for (int leader : made->leaders) made->view.n = std::max(made->view.n, leader + 1);
    made->coupling = {moved, made->leaders.data(), made->factors.data(), made->offsets.data()};
    made->chain = made->view;
    made->chain.coupling = &made->coupling;
    if (follow) made->view = made->chain;
    made_ = std::move(made);
  }

  /// Joints with a drive: those that follow others do not count.
  int n() const noexcept { return made_->view.n; }
  const ArmView& view() const noexcept { return made_->view; }
  /// Pose (12) and, unless it is null, Jacobian (6 n) at joint positions q, without other memory.
  void kinematics(const double* q, double* pose, double* jacobian) const noexcept {
    front::walk(made_->chain, q, pose, jacobian);
  }

 private:
  struct Made {
    std::vector<Link> links;
    std::vector<int> leaders;
    std::vector<double> factors, offsets;
    Coupling coupling;
    ArmView view;
    ArmView chain;  // coupled in any case
  };
  std::shared_ptr<const Made> made_;
};

/// What one solve of n joints works in.
class WorkspaceMemory {
 public:
  WorkspaceMemory() = default;
  WorkspaceMemory(int n, bool full_joint_weight) { fit(n, full_joint_weight); }
  /// Grows to what n joints need.
  void fit(int n, bool full_joint_weight) {
    const auto grow = [](auto& all, std::size_t wanted) {
      if (all.size() < wanted) all.resize(wanted);
    };
    grow(doubles_, front::doubles(n, full_joint_weight));
    grow(ints_, front::ints(n));
    grow(bytes_, front::bytes(n));
  }
  Memory view() noexcept { return {doubles_.data(), ints_.data(), bytes_.data()}; }

 private:
  std::vector<double> doubles_;
  std::vector<int> ints_;
  std::vector<std::int8_t> bytes_;
};

/// A controller's state with everything that it points to. Checks nothing: Controller of stillreach.hpp does.
class ControllerMemory {
 public:
  /// told: settings whose arm and metric outlive this; its arrays are made here, zeros, and written by the owner, who
  /// calls limits_changed() then. The joints are healthy and at rest.
  explicit ControllerMemory(const Settings& told) : workspace(told.arm.n, told.metric.joints != nullptr) {
    state.settings = told;
    each_array(state, told.arm.n, [this](auto*& to, int count) { to = room(to, to_size(count)); });
    answer.rates = room(answer.rates, to_size(told.arm.n));
    answer.residual = room(answer.residual, to_size(told.m));
    answer.active = room(answer.active, to_size(told.arm.n));
  }
  ControllerMemory(const ControllerMemory&) = delete;
  ControllerMemory& operator=(const ControllerMemory&) = delete;
  ControllerMemory(ControllerMemory&&) = default;  // what the state points to is on the heap, and stays there
  ControllerMemory& operator=(ControllerMemory&&) = default;

  ControllerState state{};
  Answer answer{};  ///< of the last tick
  WorkspaceMemory workspace;

  int n() const noexcept { return state.settings.arm.n; }

  /// An array of the settings, to write to.
  static double* writable(const double* setting) noexcept { return const_cast<double*>(setting); }
  static std::int8_t* writable(const std::int8_t* setting) noexcept { return const_cast<std::int8_t*>(setting); }

  /// Limits were written. closing: bits of Closing for those that the next ticks reach within the acceleration limits.
  void limits_changed(int closing = 0) noexcept {
    Settings& s = state.settings;
    s.constant_bounds = 1;
    state.last.bounds_stand = 0;
    for (int i = 0; i < n(); ++i) {
      s.constant_bounds &=
          std::isinf(s.position_lower[i]) && std::isinf(s.position_upper[i]) && std::isinf(s.acceleration[i]);
      state.last.closing[i] = static_cast<std::int8_t>(state.last.closing[i] | closing);
    }
    front::choose_correction(state);
  }

  void set_fault(int joint, const Fault& fault) noexcept { front::tell(state, joint, fault); }

  /// A tick; target (12) or null, period [s] of this tick alone or 0 for the controller's own. Returns the bits of
  /// Status.
  std::int32_t tick(const double* q, const double* twist, const double* target = nullptr,
                    double period = 0.0) noexcept {
    Settings& s = state.settings;
    const double own = s.period;
    const int uneven = s.uneven;
    if (period > 0.0) {
      s.period = period;
      s.uneven = 1;
    }
    front::run(state, q, twist, target, workspace.view(), answer);
    s.period = own;
    s.uneven = uneven;
    return answer.status;
  }

  /// The next tick knows of no ticks before, and of these last rates (n); null: the arm stands still. Faults stay.
  void reset(const double* rates = nullptr) noexcept {
    LastTick& last = state.last;
    for (int i = 0; i < n(); ++i) {
      last.rates[i] = rates ? rates[i] : 0.0;
      last.anchor[i] = 0.0;
      last.active[i] = 0;
    }
    last.transition = 0.0;
  }

 private:
  double* room(const double*, std::size_t count) { return numbers_.emplace_back(count).data(); }
  std::int8_t* room(const std::int8_t*, std::size_t count) { return bytes_.emplace_back(count).data(); }
  Fault* room(const Fault*, std::size_t count) {
    faults_.resize(count);
    return faults_.data();
  }

  std::vector<std::vector<double>> numbers_;
  std::vector<std::vector<std::int8_t>> bytes_;
  std::vector<Fault> faults_;
};

#if defined(STILLREACH_DISPATCH)
}  // namespace dispatched
#endif
STILLREACH_END
