// Law settings and metric as Python objects that own their memory.
#pragma once

#include <memory>
#include <vector>

#include "door.hpp"
#include "lock.hpp"
#include "stillreach/memory.hpp"

using stillreach::kernel;
using stillreach::to_size;

struct Law {
  stillreach::LawSettings settings;
};

// Units and weights of m task rows and n joints; shared by every answer that used them.
struct MetricData {
  int m, n, weightless = 0;
  std::vector<double> rows, units, columns, joints;
  stillreach::Metric view() const {
    const auto at = [](const std::vector<double>& v) { return v.empty() ? nullptr : v.data(); };
    return {at(rows), at(units), at(columns), at(joints), weightless};
  }
};

struct Metric {
  std::shared_ptr<const MetricData> data;
};

// `count` numbers of `memory` on a 64-byte boundary, as the batch functions want them.
inline double* aligned(std::vector<double>& memory, std::size_t count) {
  if (memory.size() < count + 8) memory.resize(count + 8);
  double* start = memory.data();
  while (reinterpret_cast<std::uintptr_t>(start) % 64 != 0) ++start;
  return start;
}

using Arm = stillreach::ArmMemory;

void bind_enums(nb::module_& m);
void bind_settings(nb::module_& m);
void bind_arm(nb::module_& m);
void bind_solution(nb::module_& m);
void bind_solve(nb::module_& m);
void bind_batch(nb::module_& m);
void bind_inverse(nb::module_& m);
void bind_losses(nb::module_& m);
void bind_controller(nb::module_& m);
void bind_recorder(nb::module_& m);
