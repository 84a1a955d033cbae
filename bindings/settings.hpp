// Law settings and metric as Python objects that own their memory.
#pragma once

#include <memory>
#include <vector>

#include "door.hpp"
#include "kernels.hpp"

struct Law {
  stillreach::LawSettings settings;
};

// Units and weights of m task rows and n joints; shared by every answer that used them.
struct MetricData {
  int m, n;
  std::vector<double> rows, units, columns, joints;
  stillreach::Metric view() const {
    const auto at = [](const std::vector<double>& v) { return v.empty() ? nullptr : v.data(); };
    return {at(rows), at(units), at(columns), at(joints)};
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
    const std::size_t wanted = kernel().workspace_doubles(n, full_joint_weight);
    if (doubles.size() < wanted) doubles.resize(wanted);
    if (ints.size() < 3u * n) ints.resize(3u * n);
    if (bytes.size() < 3u * n) bytes.resize(3u * n);
  }
  stillreach::Memory memory() { return {doubles.data(), ints.data(), bytes.data()}; }
};

struct Arm {
  int n;
  std::vector<double> placements;
  std::vector<std::int8_t> kinds;
  stillreach::ArmView view() const { return {n, placements.data(), kinds.data()}; }
};

void bind_settings(nb::module_& m);
void bind_arm(nb::module_& m);
void bind_solution(nb::module_& m);
void bind_solve(nb::module_& m);
void bind_controller(nb::module_& m);
