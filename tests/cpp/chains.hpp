// Arms to test with, and seeded random numbers that are the same everywhere.
#pragma once

#include <cstdint>
#include <vector>

#include "stillreach/memory.hpp"

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180.0;

struct Random {  // xorshift64* (Vigna, 2016)
  std::uint64_t state;
  explicit Random(std::uint64_t seed) : state(seed * 0x9e3779b97f4a7c15ull + 1) {}
  double between(double low, double high) {
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    const double unit = static_cast<double>((state * 0x2545f4914f6cdd1dull) >> 11) * 0x1p-53;
    return low + (high - low) * unit;
  }
  int below(int n) { return static_cast<int>(between(0.0, n)); }
  std::vector<double> vector(int n, double size) {
    std::vector<double> v(n);
    for (double& x : v) x = between(-size, size);
    return v;
  }
};

// Poses and axes as a user has them: n + 1 row-major 4 x 4 placements, the last one the tool.
struct Chain {
  std::vector<double> placements, axes;
  std::vector<stillreach::JointKind> kinds;
  int n() const { return static_cast<int>(kinds.size()); }
  stillreach::ArmMemory arm() const { return {kinds, placements.data(), axes.data()}; }

  void shift(double x, double y, double z) {
    const double T[16] = {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1};
    placements.insert(placements.end(), T, T + 16);
  }
  void joint(double x, double y, double z, double ax, double ay, double az,
             stillreach::JointKind kind = stillreach::JointKind::REVOLUTE) {
    shift(x, y, z);
    axes.insert(axes.end(), {ax, ay, az});
    kinds.push_back(kind);
  }
};

inline Chain planar_chain(int n) {  // unit links along x that turn about z
  Chain c;
  for (int i = 0; i < n; ++i) c.joint(i ? 1.0 : 0.0, 0, 0, 0, 0, 1);
  c.shift(1, 0, 0);
  return c;
}

// Roll about +z in the middle of a segment, pitch about -y at its end: 11 joints, six segments of 0.762 m.
inline Chain paper_chain() {
  const double half = 0.381;
  Chain c;
  for (int i = 0; i < 11; ++i)
    if (i % 2 == 0)
      c.joint(0, 0, half, 0, 0, 1);
    else
      c.joint(0, 0, half, 0, -1, 0);
  c.shift(0, 0, half);
  return c;
}

inline Chain snake_chain(int n) {  // links of 0.1 m that pitch and yaw in turn
  Chain c;
  for (int i = 0; i < n; ++i) c.joint(i ? 0.1 : 0.0, 0, 0, 0, i % 2 ? 0.0 : 1.0, i % 2 ? 1.0 : 0.0);
  c.shift(0.1, 0, 0);
  return c;
}

// Axes in every direction (z, -z and nearly -z among them), every fourth joint prismatic.
inline Chain skew_chain(int n, std::uint64_t seed) {
  Random random(seed);
  Chain c;
  for (int i = 0; i < n; ++i) {
    double a[3] = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    if (i % 5 == 0) {
      a[0] = a[1] = 0.0;
      a[2] = i % 2 ? -1.0 : 1.0;
    }
    if (i % 5 == 1) {
      a[0] = 1e-9;
      a[1] = 0.0;
      a[2] = -1.0;
    }
    const double size = __builtin_sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    const double at[3] = {random.between(-0.4, 0.4), random.between(-0.4, 0.4),
                          random.between(0.1, 0.5)};  // in this order
    c.joint(at[0], at[1], at[2], a[0] / size, a[1] / size, a[2] / size,
            i % 4 == 3 ? stillreach::JointKind::PRISMATIC : stillreach::JointKind::REVOLUTE);
  }
  c.shift(0.1, 0.2, 0.3);
  return c;
}
