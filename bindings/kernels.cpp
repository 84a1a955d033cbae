#include "kernels.hpp"

#include <cstdlib>
#include <cstring>

static const stillreach::Kernel& choose() {
#if defined(__x86_64__) && defined(__GNUC__)
  const char* most = std::getenv("STILLREACH_INSTRUCTIONS");
  const auto asked = [most](const char* set) { return most && std::strcmp(most, set) == 0; };
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && !asked("baseline");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  if (avx2 && avx512 && !asked("avx2")) return stillreach_kernel_avx512();
  if (avx2) return stillreach_kernel_avx2();
#endif
  return stillreach_kernel_baseline();
}

const stillreach::Kernel& kernel() {
  static const stillreach::Kernel& chosen = choose();
  return chosen;
}
