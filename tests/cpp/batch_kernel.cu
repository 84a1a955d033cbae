// The headers as CUDA: one problem a thread, each with a workspace of its own. Compiled by test_cuda.py, run nowhere
// here.
#include "stillreach/cuda.hpp"

namespace {

using stillreach::Answer;

__device__ int thread() { return static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x); }

__device__ stillreach::Workspace workspace(int n, bool full, int row, double* doubles, int* ints, std::int8_t* bytes) {
  return stillreach::make_workspace(n, full, doubles + row * stillreach::workspace_doubles(n, full),
                                    ints + row * stillreach::workspace_ints(n),
                                    bytes + row * stillreach::workspace_bytes(n));
}

}  // namespace

// Any law on Jacobians: bounds and metric are shared by all rows.
extern "C" __global__ void solve_rows_of_jacobians(int count, stillreach::LawSettings law, stillreach::Problem shared,
                                                   const double* jacobians, const double* twists, double* doubles,
                                                   int* ints, std::int8_t* bytes, Answer* answers) {
  const int row = thread();
  if (row >= count) return;
  stillreach::Problem p = shared;
  p.jacobian = jacobians + static_cast<std::size_t>(row) * p.m * p.n;
  p.twist = twists + static_cast<std::size_t>(row) * p.m;
  stillreach::Workspace w = workspace(p.n, p.metric.joints != nullptr, row, doubles, ints, bytes);
  stillreach::solve_law(law, p, w, answers[row]);
}

// Whole ticks: kinematics, bounds, null motion, law.
extern "C" __global__ void tick_rows(int count, stillreach::ControllerState* controllers, const double* q,
                                     const double* twists, const double* targets, double* doubles, int* ints,
                                     std::int8_t* bytes, Answer* answers) {
  const int row = thread();
  if (row >= count) return;
  stillreach::ControllerState& c = controllers[row];
  stillreach::Workspace w = workspace(c.settings.arm.n, c.settings.metric.joints != nullptr, row, doubles, ints, bytes);
  stillreach::tick(c, q + static_cast<std::size_t>(row) * c.settings.arm.n, twists + 6 * static_cast<std::size_t>(row),
                   targets ? targets + 12 * static_cast<std::size_t>(row) : nullptr, w, answers[row]);
}
