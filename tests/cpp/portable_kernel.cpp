// The kernel of a compiler without vectors, with and without fused multiply-add; see CMakeLists.txt.
#include "portable_kernel.hpp"

#if defined(__AVX2__) && defined(__FMA__)
const stillreach::Kernel& portable_kernel_fma() {
#else
const stillreach::Kernel& portable_kernel() {
#endif
  static const stillreach::Kernel kernel = stillreach::make_kernel();
  return kernel;
}
