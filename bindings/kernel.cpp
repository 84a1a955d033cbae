// Compiled once per instruction set; see CMakeLists.txt.
#include "stillreach/kernel.hpp"

#include "kernels.hpp"

#if defined(STILLREACH_WIDE)
const stillreach::Kernel& stillreach_kernel_avx512() {
#elif defined(__AVX2__) && defined(__FMA__)
const stillreach::Kernel& stillreach_kernel_avx2() {
#else
const stillreach::Kernel& stillreach_kernel_baseline() {
#endif
  static const stillreach::Kernel kernel = stillreach::make_kernel();
  return kernel;
}
