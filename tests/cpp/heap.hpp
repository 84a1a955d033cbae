// Counts what is taken from the heap: malloc and its relatives, operator new, in this whole program. Include it in the
// one file that has main.
#pragma once

#include <cerrno>
#include <cstdlib>
#include <new>

#include "stillreach/config.hpp"

inline volatile long heap_calls = 0;  // since the program began
inline volatile long new_calls = 0;

#if defined(__GLIBC__)

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  heap_calls = heap_calls + 1;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  heap_calls = heap_calls + 1;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  heap_calls = heap_calls + 1;
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  heap_calls = heap_calls + 1;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  *out = memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}
}

#endif

STILLREACH_NOINLINE void* operator new(std::size_t size) {
  new_calls = new_calls + 1;
  if (void* block = std::malloc(size ? size : 1)) return block;
  throw std::bad_alloc();
}
STILLREACH_NOINLINE void* operator new(std::size_t size, std::align_val_t alignment) {
  new_calls = new_calls + 1;
  const std::size_t a = static_cast<std::size_t>(alignment);
  if (void* block = std::aligned_alloc(a, (size + a - 1) / a * a)) return block;
  throw std::bad_alloc();
}
STILLREACH_NOINLINE void operator delete(void* block) noexcept { std::free(block); }
STILLREACH_NOINLINE void operator delete(void* block, std::size_t) noexcept { std::free(block); }
STILLREACH_NOINLINE void operator delete(void* block, std::align_val_t) noexcept { std::free(block); }
STILLREACH_NOINLINE void operator delete(void* block, std::size_t, std::align_val_t) noexcept { std::free(block); }
