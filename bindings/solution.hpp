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
  std::unique_ptr<double[]>
      numbers;  // jacobian m n (by columns), lower n, upper n, twist m, residual m, multiplier m; reasons n bytes

  std::size_t memory_bytes() const { return sizeof(double) * to_size(m * n + 2 * n + 3 * m) + to_size(n); }
  void make_room() { numbers.reset(new double[memory_bytes() / sizeof(double) + 1]); }
  double* jacobian() const { return numbers.get(); }
  double* lower() const { return jacobian() + m * n; }
  double* upper() const { return lower() + n; }
  double* twist() const { return upper() + n; }
  double* residual() const { return twist() + m; }
  double* multiplier() const { return residual() + m; }
  std::int8_t* reasons() const { return static_cast<std::int8_t*>(static_cast<void*>(multiplier() + m)); }
  // R'u, in the units of the twist.
  void set_multiplier(const stillreach::Multiplier& from) {
    for (int c = 0; c < m; ++c) {
      double sum = metric->rows.empty() ? from.u[c] : 0.0;
      for (int r = 0; r <= c && !metric->rows.empty(); ++r) sum += metric->rows[to_size(r * m + c)] * from.u[r];
      multiplier()[c] = from.known ? sum : 0.0;
    }
  }
};

// The Status member for a value; made once each.
nb::object status_object(std::int32_t value);
