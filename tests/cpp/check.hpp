// CHECK without a framework: says what did not hold and where; the test ends with failures() as its exit code.
#pragma once

#include <cmath>
#include <cstdio>

inline int& failures() {
  static int count = 0;
  return count;
}

inline void check(bool holds, const char* what, const char* file, int line) {
  if (holds) return;
  if (++failures() <= 20) std::fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, what);
}

inline void check_near(double value, double expected, double tolerance, const char* what, const char* file, int line) {
  if (std::fabs(value - expected) <= tolerance) return;
  if (++failures() <= 20)
    std::fprintf(stderr, "%s:%d: %s is %.17g, expected %.17g within %g\n", file, line, what, value, expected,
                 tolerance);
}

#define CHECK(condition) check((condition), #condition, __FILE__, __LINE__)
#define CHECK_NEAR(value, expected, tolerance) check_near((value), (expected), (tolerance), #value, __FILE__, __LINE__)

// Last line of every main.
inline int finish(const char* name) {
  std::fprintf(stderr, "%s: %d failures\n", name, failures());
  return failures() == 0 ? 0 : 1;
}
