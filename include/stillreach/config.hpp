// Instruction sets: every function of the core lives in an inline namespace named after the set it is compiled for,
// so that several builds of one header in one program never share a symbol. CUDA counts as one, for its host side, too.
#pragma once

#if defined(__CUDACC_RTC__)  // run-time compilation has no headers of a host
namespace std {
using size_t = decltype(sizeof 0);
using ptrdiff_t = long long;
using int8_t = signed char;
using int32_t = int;
}  // namespace std
#else
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#endif

// Packs as plain structs: for compilers without vectors (portable_pack.hpp).
#if !defined(STILLREACH_PORTABLE_PACK) && (defined(__CUDACC__) || !defined(__GNUC__))
#define STILLREACH_PORTABLE_PACK
#endif

#if defined(__CUDACC__)
#define STILLREACH_ISA cuda
#elif defined(STILLREACH_PORTABLE_PACK) && defined(__FMA__)
#define STILLREACH_ISA portable_fma
#elif defined(STILLREACH_PORTABLE_PACK)
#define STILLREACH_ISA portable
#elif defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__FMA__)
#define STILLREACH_ISA avx512
#define STILLREACH_WIDE  // lanes.hpp: eight problems at once
#elif defined(__AVX2__) && defined(__FMA__)
#define STILLREACH_ISA avx2
#else
#define STILLREACH_ISA baseline
#endif

#define STILLREACH_STRINGIFY_(x) #x
#define STILLREACH_STRINGIFY(x) STILLREACH_STRINGIFY_(x)
#define STILLREACH_PASTE_(a, b) a##b
#define STILLREACH_PASTE(a, b) STILLREACH_PASTE_(a, b)

// A kernel of stillreach::dispatch has a namespace of its own: it shares no symbol with a program that uses the headers
// for the same instruction set with other options.
#if defined(STILLREACH_KERNEL)
#define STILLREACH_NAMESPACE STILLREACH_PASTE(kernel_of_, STILLREACH_ISA)
#else
#define STILLREACH_NAMESPACE STILLREACH_ISA
#endif

// Clang warns at each call that the ABI for passing packs depends on the instruction set; such calls are inlined.
#if defined(__clang__) && !defined(__CUDACC__)
#define STILLREACH_QUIET _Pragma("clang diagnostic push") _Pragma("clang diagnostic ignored \"-Wpsabi\"")
#define STILLREACH_AS_BEFORE _Pragma("clang diagnostic pop")
#else
#define STILLREACH_QUIET
#define STILLREACH_AS_BEFORE
#endif

#define STILLREACH_BEGIN \
  STILLREACH_QUIET       \
  namespace stillreach { \
  STILLREACH_KEYWORD namespace STILLREACH_NAMESPACE {
#define STILLREACH_END \
  }                    \
  }                    \
  STILLREACH_AS_BEFORE

#if defined(__CUDACC__)
#define STILLREACH_KEYWORD __inline__                     // cuda.hpp gives the plain word a longer meaning
#define STILLREACH_INLINE __inline__ __host__ __device__  // never forced: that makes code of many megabytes
#define STILLREACH_NOINLINE
#elif defined(__GNUC__)
#define STILLREACH_KEYWORD inline
#define STILLREACH_INLINE inline __attribute__((always_inline))
#define STILLREACH_NOINLINE __attribute__((noinline))
#else
#define STILLREACH_KEYWORD inline
#define STILLREACH_INLINE inline
#define STILLREACH_NOINLINE
#endif

// Before a loop over so few rows that it is written out where their number is known.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define STILLREACH_UNROLL _Pragma("GCC unroll 8")
#else
#define STILLREACH_UNROLL
#endif

// A function of the C library by its name: the compiler's own, or CUDA's.
#if defined(__GNUC__) && !defined(__CUDACC__)
#define STILLREACH_LIBRARY(name) __builtin_##name
#else
#define STILLREACH_LIBRARY(name) ::name
#endif
