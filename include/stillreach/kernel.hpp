// What a program calls after it chose an instruction set at run time: a table of functions, one table a set.
#pragma once

#include "stillreach/batch/batch.hpp"
#include "stillreach/batch/batch_kinematics.hpp"
#include "stillreach/batch/batch_rollout.hpp"
#include "stillreach/batch/guaranteed.hpp"
#include "stillreach/batch/inverse.hpp"
#include "stillreach/control/rollout.hpp"
#include "stillreach/kinematics/arm.hpp"
#include "stillreach/kinematics/coupled.hpp"

namespace stillreach {

struct Kernel {
  const char* instruction_set;
  std::size_t (*workspace_doubles)(int n, bool full_joint_weight);
  std::size_t (*workspace_ints)(int n);
  std::size_t (*workspace_bytes)(int n);
  ArmView (*align_axes)(int n, const JointKind* kinds, const double* placements, const double* axes, Link* links);
  void (*kinematics)(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian);
  void (*solve)(const LawSettings& law, const Problem& p, const Memory& memory, Answer& out);
  double (*typical_rate)(int n, const double* lower, const double* upper, const Metric& metric);
  bool (*read_pose)(const double* T, double* pose);
  void (*pose_distances)(const double* actual, const double* wanted, long count, const double* asked, bool along_pose,
                         double* off);
  void (*set_fault)(ControllerState& c, int joint, const Fault& fault);
  void (*bound_correction)(ControllerState& c);
  void (*tick)(ControllerState& c, const double* q, const double* twist, const double* target, const Memory& memory,
               Answer& out);
  void (*rollout)(ControllerState& c, double* q, const double* twists, const double* targets, long steps, int stages,
                  bool advance, Plant* plant, const Memory& memory, Answer& a, double* scratch,
                  std::int8_t* scratch_active, const Record& to);
  // Rows first to last - 1 of a batch. memory: as long as these say, doubles on a 64-byte boundary.
  void (*batch)(const Batch& b, std::ptrdiff_t first, std::ptrdiff_t last, const Memory& memory);
  std::size_t (*batch_doubles)(int n, bool full_joint_weight);
  std::size_t (*batch_ints)(int n);
  std::size_t (*batch_bytes)(int n);
  // Rows first to last - 1, at most kRolloutBlock, of a batch of rollouts. doubles: rollout_doubles more.
  void (*rollout_rows)(const BatchRollout& r, std::ptrdiff_t first, std::ptrdiff_t last, const Memory& memory,
                       double* doubles);
  std::size_t (*rollout_doubles)(int n);
  // Rows first to last - 1 of an inverse. doubles: inverse_doubles more.
  void (*inverse_rows)(const Inverse& v, std::ptrdiff_t first, std::ptrdiff_t last, const Memory& memory,
                       double* doubles);
  std::size_t (*inverse_doubles)(int n);
  // Rows first to last - 1 of poses, Jacobians, singular values. doubles: as many as that says, on a 64-byte boundary.
  void (*kinematics_rows)(const KinematicsBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles);
  std::size_t (*kinematics_doubles)(int n, int count, bool full_joint_weight);
  // Rows first to last - 1 of what losses leave. doubles: as many as that says, on a 64-byte boundary.
  void (*relative_rows)(const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles);
  void (*guaranteed_rows)(const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles);
  std::size_t (*loss_doubles)(int n, int sizes, std::ptrdiff_t count);
};

}  // namespace stillreach

STILLREACH_BEGIN

// The table of the instruction set that this file is compiled for.
inline Kernel make_kernel() {
  Kernel k;
  k.instruction_set = STILLREACH_STRINGIFY(STILLREACH_ISA);
  k.workspace_doubles = [](int n, bool full) { return workspace_doubles(n, full); };
  k.workspace_ints = [](int n) { return workspace_ints(n); };
  k.workspace_bytes = [](int n) { return workspace_bytes(n); };
  k.align_axes = [](int n, const JointKind* kinds, const double* placements, const double* axes, Link* links) {
    return align_axes(n, kinds, placements, axes, links);
  };
  k.kinematics = [](const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
    arm_kinematics(arm, q, scratch, pose, jacobian);
  };
  k.solve = [](const LawSettings& law, const Problem& p, const Memory& memory, Answer& out) {
    Workspace w = make_workspace(p.n, p.metric.joints != nullptr, memory);
    solve_law(law, p, w, out);
  };
  k.typical_rate = [](int n, const double* lower, const double* upper, const Metric& metric) {
    return typical_rate(n, lower, upper, metric);
  };
  k.read_pose = [](const double* T, double* pose) { return read_pose(T, pose); };
  k.pose_distances = [](const double* actual, const double* wanted, long count, const double* asked, bool along_pose,
                        double* off) { pose_distances(actual, wanted, count, asked, along_pose, off); };
  k.set_fault = [](ControllerState& c, int joint, const Fault& fault) { set_fault(c, joint, fault); };
  k.bound_correction = [](ControllerState& c) { bound_correction(c.settings, c.faults, c.now.scratch); };
  k.tick = [](ControllerState& c, const double* q, const double* twist, const double* target, const Memory& memory,
              Answer& out) {
    Workspace w = make_workspace(c.settings.arm.n, c.settings.metric.joints != nullptr, memory);
    tick(c, q, twist, target, w, out);
  };
  k.rollout = [](ControllerState& c, double* q, const double* twists, const double* targets, long steps, int stages,
                 bool advance, Plant* plant, const Memory& memory, Answer& a, double* scratch,
                 std::int8_t* scratch_active, const Record& to) {
    Workspace w = make_workspace(c.settings.arm.n, c.settings.metric.joints != nullptr, memory);
    rollout(c, q, twists, targets, steps, stages, advance, plant, w, a, scratch, scratch_active, to);
  };
  k.batch = [](const Batch& b, std::ptrdiff_t first, std::ptrdiff_t last, const Memory& memory) {
    BatchMemory w = make_batch_memory(b.arm.n, b.metric.joints != nullptr, memory.doubles, memory.ints, memory.bytes);
    solve_rows(b, first, last, w);
  };
  k.rollout_rows = [](const BatchRollout& r, std::ptrdiff_t first, std::ptrdiff_t last, const Memory& memory,
                      double* doubles) {
    const Batch& b = r.batch;
    BatchMemory w = make_batch_memory(b.arm.n, b.metric.joints != nullptr, memory.doubles, memory.ints, memory.bytes);
    RolloutMemory own = make_rollout_memory(b.arm.n, doubles);
    rollout_rows(r, first, last, w, own);
  };
  k.rollout_doubles = [](int n) { return rollout_doubles(n); };
  k.inverse_rows = [](const Inverse& v, std::ptrdiff_t first, std::ptrdiff_t last, const Memory& memory,
                      double* doubles) {
    const Batch& b = v.batch;
    BatchMemory w = make_batch_memory(b.arm.n, b.metric.joints != nullptr, memory.doubles, memory.ints, memory.bytes);
    InverseMemory own;
    set_inverse_memory(b.arm.n, doubles, own);
    inverse_rows(v, first, last, w, own);
  };
  k.inverse_doubles = [](int n) { return inverse_doubles(n); };
  k.batch_doubles = [](int n, bool full) { return batch_doubles(n, full); };
  k.batch_ints = [](int n) { return batch_ints(n); };
  k.batch_bytes = [](int n) { return batch_bytes(n); };
  k.kinematics_rows = [](const KinematicsBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles) {
    kinematics_rows(b, first, last, doubles);
  };
  k.kinematics_doubles = [](int n, int count, bool full) { return kinematics_doubles(n, count, full); };
  k.relative_rows = [](const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles) {
    relative_rows(b, first, last, doubles);
  };
  k.guaranteed_rows = [](const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles) {
    guaranteed_rows(b, first, last, doubles);
  };
  k.loss_doubles = [](int n, int sizes, std::ptrdiff_t count) { return loss_doubles(n, sizes, count); };
  return k;
}

STILLREACH_END
