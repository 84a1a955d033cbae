#include "kernels.hpp"

#include <cstdlib>
#include <cstring>

static const stillreach::Kernel& choose() {
#if defined(__x86_64__) && defined(__GNUC__)
  const char* wanted = std::getenv("STILLREACH_INSTRUCTIONS");
  const bool baseline = wanted && std::strcmp(wanted, "baseline") == 0;
  if (!baseline && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return stillreach_kernel_avx2();
#endif
  return stillreach_kernel_baseline();
}

const stillreach::Kernel& kernel() {
  static const stillreach::Kernel& chosen = choose();
  return chosen;
}
