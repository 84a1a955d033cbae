#pragma once

#include <cstdlib>

#include "check.hpp"

// Numbers on a 64-byte boundary, not one more than asked for.
struct Aligned {
  double* data = nullptr;
  explicit Aligned(std::size_t count) {
    void* memory = nullptr;
    CHECK(posix_memalign(&memory, 64, sizeof(double) * count) == 0);
    data = static_cast<double*>(memory);
    for (std::size_t i = 0; i < count; ++i) data[i] = -7e77;
  }
  Aligned(const Aligned&) = delete;
  Aligned& operator=(const Aligned&) = delete;
  ~Aligned() { std::free(data); }
};
