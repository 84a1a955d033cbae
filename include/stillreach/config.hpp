// Instruction sets: every function of the core lives in an inline namespace named after the set it is compiled for,
// so that two builds of one header in one program never share a symbol.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#if defined(__AVX2__) && defined(__FMA__)
#define STILLREACH_ISA avx2
#else
#define STILLREACH_ISA baseline
#endif

#define STILLREACH_BEGIN      \
  namespace stillreach {      \
  inline namespace STILLREACH_ISA {
#define STILLREACH_END \
  }                    \
  }

#define STILLREACH_STRINGIFY_(x) #x
#define STILLREACH_STRINGIFY(x) STILLREACH_STRINGIFY_(x)

#if defined(__GNUC__)
#define STILLREACH_INLINE inline __attribute__((always_inline))
#define STILLREACH_NOINLINE __attribute__((noinline))
#define STILLREACH_RESTRICT __restrict__
#else
#define STILLREACH_INLINE inline
#define STILLREACH_NOINLINE
#define STILLREACH_RESTRICT
#endif
