// What a law answered, with the data it answered from, so that the answer can be checked and looked into later.
#pragma once

#include "settings.hpp"

struct Solution {
  nb::object rates;  // (n,) float64
  std::shared_ptr<const MetricData> metric;
  int m, n;
  std::int32_t status;
  int iterations;
  double damping, scale, task_error, rank_tolerance;
  std::unique_ptr<double[]> numbers;  // jacobian m n (by columns), lower n, upper n, twist m, residual m; reasons n bytes

  std::size_t memory_bytes() const { return sizeof(double) * (static_cast<std::size_t>(m) * n + 2 * n + 2 * m) + n; }
  void make_room() { numbers.reset(new double[memory_bytes() / sizeof(double) + 1]); }
  double* jacobian() const { return numbers.get(); }
  double* lower() const { return jacobian() + static_cast<std::size_t>(m) * n; }
  double* upper() const { return lower() + n; }
  double* twist() const { return upper() + n; }
  double* residual() const { return twist() + m; }
  std::int8_t* reasons() const { return static_cast<std::int8_t*>(static_cast<void*>(residual() + m)); }
};

// The Status member for a value; made once each.
nb::object status_object(std::int32_t value);

// Why joint i is at its bound, signed: from the answer's active code and the reasons of its two bounds.
inline std::int8_t active_reason(std::int8_t active, std::int8_t lower_reason, std::int8_t upper_reason) {
  return active == 0 ? 0 : active < 0 ? static_cast<std::int8_t>(-lower_reason) : upper_reason;
}
