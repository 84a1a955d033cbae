// Law settings and metric as Python objects that own their memory.
#pragma once

#include <memory>
#include <vector>

#include "door.hpp"
#include "lock.hpp"
#include "stillreach/dispatch.hpp"

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

// The core's scratch memory for n joints.
struct Scratch {
  std::vector<double> doubles;
  std::vector<int> ints;
  std::vector<std::int8_t> bytes;
  void fit(int n, bool full_joint_weight) {
    const auto grow = [](auto& memory, std::size_t wanted) {
      if (memory.size() < wanted) memory.resize(wanted);
    };
    grow(doubles, kernel().workspace_doubles(n, full_joint_weight));
    grow(ints, kernel().workspace_ints(n));
    grow(bytes, kernel().workspace_bytes(n));
  }
  stillreach::Memory memory() { return {doubles.data(), ints.data(), bytes.data()}; }
};

// `count` numbers of `memory` on a 64-byte boundary, as the batch functions want them.
inline double* aligned(std::vector<double>& memory, std::size_t count) {
  if (memory.size() < count + 8) memory.resize(count + 8);
  double* start = memory.data();
  while (reinterpret_cast<std::uintptr_t>(start) % 64 != 0) ++start;
  return start;
}

struct Arm {
  int n;
  std::vector<stillreach::Link> links;
  stillreach::ArmView chain;  // as align_axes() made it
  std::vector<int> leaders;   // empty where every joint moves alone, else as Coupling has it
  std::vector<double> factors, offsets;
  mutable stillreach::Coupling coupling{};
  stillreach::ArmView view() const {
    coupling = {static_cast<int>(leaders.size()), leaders.data(), factors.data(), offsets.data()};
    stillreach::ArmView arm = chain;
    arm.n = n;
    arm.links = links.data();
    arm.coupling = leaders.empty() ? nullptr : &coupling;
    return arm;
  }
};

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
