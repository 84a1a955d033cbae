// Compiled once per instruction set, STILLREACH_KERNEL being its name; see stillreach-dispatch.cmake.
#include "kernels.hpp"

const stillreach::Kernel& stillreach::STILLREACH_PASTE(kernel_, STILLREACH_KERNEL)() {
  static const Kernel kernel = make_kernel();
  return kernel;
}
