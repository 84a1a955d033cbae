// The core in a CUDA program (nvcc, or run-time compilation): every function, for host and device. Include it before
// any other header of the core.
#pragma once

#include "stillreach/config.hpp"

#define inline __inline__ __host__ __device__ __noinline__
#include "stillreach/control/rollout.hpp"
#include "stillreach/kinematics/arm.hpp"
#undef inline
