// The core for the processor that runs the program: link the CMake target stillreach::dispatch, which compiles it once
// for each instruction set.
#pragma once

#include "stillreach/kernel.hpp"

namespace stillreach {

// The best kernel for this processor, but none beyond the one that the environment variable STILLREACH_INSTRUCTIONS
// names ("baseline", "avx2", "avx512"). The choice is made at the first call.
const Kernel& kernel();

}  // namespace stillreach
