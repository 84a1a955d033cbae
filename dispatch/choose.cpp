#include "stillreach/dispatch.hpp"

#include <cstdlib>
#include <cstring>

#include "kernels.hpp"

namespace {

using stillreach::Kernel;

#if defined(STILLREACH_WITH_AVX512)
// Batches in eight lanes. One problem at a time has four numbers to a register, where AVX2's code is the faster.
const Kernel& eight_lanes() {
  static const Kernel both = [] {
    const Kernel& wide = stillreach::kernel_avx512();
    Kernel k = stillreach::kernel_avx2();
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

const Kernel& best_kernel() {
#if defined(STILLREACH_WITH_AVX2)
  const char* most = std::getenv("STILLREACH_INSTRUCTIONS");
  const auto named = [most](const char* set) { return most && std::strcmp(most, set) == 0; };
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && !named("baseline");
#if defined(STILLREACH_WITH_AVX512)
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
  if (avx2 && avx512 && !named("avx2")) return eight_lanes();
#endif
  if (avx2) return stillreach::kernel_avx2();
#endif
  return stillreach::kernel_baseline();
}

}  // namespace

const stillreach::Kernel& stillreach::kernel() {
  static const Kernel& chosen = best_kernel();
  return chosen;
}
