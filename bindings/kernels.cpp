#include "kernels.hpp"

#include <cstdlib>
#include <cstring>

#if defined(__x86_64__) && defined(__GNUC__)
// Batches in eight lanes. One problem at a time has four numbers to a register, where AVX2's code is the faster.
static const stillreach::Kernel& eight_lanes() {
  static const stillreach::Kernel both = [] {
    const stillreach::Kernel& wide = stillreach_kernel_avx512();
    stillreach::Kernel k = stillreach_kernel_avx2();
    k.instruction_set = wide.instruction_set;
    k.batch = wide.batch;
    k.batch_doubles = wide.batch_doubles;
    k.batch_ints = wide.batch_ints;
    k.batch_bytes = wide.batch_bytes;
    k.rollout_rows = wide.rollout_rows;
    k.rollout_doubles = wide.rollout_doubles;
    k.kinematics_rows = wide.kinematics_rows;
    k.kinematics_doubles = wide.kinematics_doubles;
    return k;
  }();
  return both;
}
#endif

static const stillreach::Kernel& choose() {
#if defined(__x86_64__) && defined(__GNUC__)
  const char* most = std::getenv("STILLREACH_INSTRUCTIONS");
  const auto asked = [most](const char* set) { return most && std::strcmp(most, set) == 0; };
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && !asked("baseline");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
  if (avx2 && avx512 && !asked("avx2")) return eight_lanes();
  if (avx2) return stillreach_kernel_avx2();
#endif
  return stillreach_kernel_baseline();
}

const stillreach::Kernel& kernel() {
  static const stillreach::Kernel& chosen = choose();
  return chosen;
}
