#include "stillreach/dispatch.hpp"

#if defined(STILLREACH_WITH_AVX2)
#include <cpuid.h>
#endif
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
    k.relative_rows = wide.relative_rows;
    k.guaranteed_rows = wide.guaranteed_rows;
    k.loss_doubles = wide.loss_doubles;
    return k;
  }();
  return both;
}
#endif

#if defined(STILLREACH_WITH_AVX2)
struct Processor {
  bool avx2 = false, avx512 = false;
};

// What the processor has and the operating system keeps between threads. Not every compiler's runtime answers
// __builtin_cpu_supports: Zig's always says no.
Processor processor() {
  constexpr unsigned ymm = 0x06, zmm = 0xe6;  // parts of the state that the system keeps
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE) || !(c & bit_FMA)) return {};
  unsigned kept = 0, upper = 0;
  __asm__ volatile("xgetbv" : "=a"(kept), "=d"(upper) : "c"(0));
  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return {};
  Processor has;
  has.avx2 = (kept & ymm) == ymm && (b & bit_AVX2);
  has.avx512 = has.avx2 && (kept & zmm) == zmm && (b & bit_AVX512F) && (b & bit_AVX512DQ);
  return has;
}
#endif

const Kernel& best_kernel() {
#if defined(STILLREACH_WITH_AVX2)
  const char* most = std::getenv("STILLREACH_INSTRUCTIONS");
  const auto named = [most](const char* set) { return most && std::strcmp(most, set) == 0; };
  const Processor has = processor();
  const bool avx2 = has.avx2 && !named("baseline");
#if defined(STILLREACH_WITH_AVX512)
  if (avx2 && has.avx512 && !named("avx2")) return eight_lanes();
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
