// The headers as compilers without vectors see them: Pack is a plain struct (portable_pack.hpp), as it is in CUDA.
#pragma once

#include "stillreach/kernel.hpp"

const stillreach::Kernel& portable_kernel();
const stillreach::Kernel& portable_kernel_fma();
