// The kernels that are linked: STILLREACH_WITH_AVX2 and STILLREACH_WITH_AVX512 where they were built.
#pragma once

#include "stillreach/kernel.hpp"

namespace stillreach {

const Kernel& kernel_baseline();
const Kernel& kernel_avx2();
const Kernel& kernel_avx512();

}  // namespace stillreach
