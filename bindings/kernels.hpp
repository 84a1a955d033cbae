// The kernels that were built, and the one that this machine runs.
#pragma once

#include "stillreach/kernel.hpp"

const stillreach::Kernel& stillreach_kernel_baseline();
const stillreach::Kernel& stillreach_kernel_avx2();
const stillreach::Kernel& stillreach_kernel_avx512();

// The best one for this processor, but none beyond the one that STILLREACH_INSTRUCTIONS names ("baseline", "avx2", "avx512").
const stillreach::Kernel& kernel();
