// Rigid transforms of robot files: 4 x 4, row-major.
#pragma once

#include <array>
#include <cmath>

#include "stillreach/types.hpp"

STILLREACH_BEGIN
namespace urdf {

using Vector = std::array<double, 3>;

struct Transform {
  double T[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  double& operator()(int r, int c) { return T[4 * r + c]; }
  double operator()(int r, int c) const { return T[4 * r + c]; }
};

inline Transform operator*(const Transform& a, const Transform& b) {
  Transform product;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) {
      product(r, c) = c == 3 ? a(r, 3) : 0.0;
      for (int k = 0; k < 3; ++k) product(r, c) += a(r, k) * b(k, c);
    }
  return product;
}

inline Transform shifted(const Vector& by) {
  Transform t;
  for (int r = 0; r < 3; ++r) t(r, 3) = by[static_cast<std::size_t>(r)];
  return t;
}

inline Transform inverse(const Transform& t) {
  Transform back;
  for (int r = 0; r < 3; ++r) {
    back(r, 3) = 0.0;
    for (int c = 0; c < 3; ++c) {
      back(r, c) = t(c, r);
      back(r, 3) -= t(c, r) * t(c, 3);
    }
  }
  return back;
}

// A turn about an axis of length 1 (Rodrigues, 1840).
inline Transform turned(const Vector& axis, double angle) {
  const double s = std::sin(angle), h = std::sin(angle / 2), v = 2 * h * h;
  const double x = axis[0], y = axis[1], z = axis[2];
  Transform t;
  const double rows[9] = {1 - v * (y * y + z * z), v * x * y - s * z,       v * x * z + s * y,
                          v * x * y + s * z,       1 - v * (x * x + z * z), v * y * z - s * x,
                          v * x * z - s * y,       v * y * z + s * x,       1 - v * (x * x + y * y)};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) t(r, c) = rows[3 * r + c];
  return t;
}

// Roll, pitch and yaw: about z of what is about y of what is about x.
inline Transform turned_by_angles(double roll, double pitch, double yaw) {
  return turned({0, 0, 1}, yaw) * turned({0, 1, 0}, pitch) * turned({1, 0, 0}, roll);
}

// Of a vector of any length but 0.
template <std::size_t N>
std::array<double, N> unit(std::array<double, N> v) {
  double largest = 0.0, square = 0.0;
  for (double x : v) largest = std::fmax(largest, std::abs(x));
  for (double& x : v) {
    x /= largest;  // no overflow or underflow in the length
    square += x * x;
  }
  for (double& x : v) x /= std::sqrt(square);
  return v;
}

inline Transform turned_by_quaternion(const std::array<double, 4>& any) {
  const std::array<double, 4> q = unit(any);
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  const double rows[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  Transform t;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) t(r, c) = rows[3 * r + c];
  return t;
}

// The motion of a joint at a position.
inline Transform moved(JointKind kind, const Vector& axis, double position) {
  if (kind == JointKind::REVOLUTE) return turned(axis, position);
  return shifted({position * axis[0], position * axis[1], position * axis[2]});
}

// Two directions across an axis of length 1: x and y after the shortest turn of z into it; to -z that is about x.
inline void across(const Vector& axis, Vector& first, Vector& second) {
  const double x = axis[0], y = axis[1], z = axis[2], off = x * x + y * y;
  if (off < 1e-18) {  // rounding of +z or -z
    first = {1, 0, 0};
    second = {0, std::copysign(1.0, z), 0};
    return;
  }
  const double k = z > 0.0 ? 1.0 / (1.0 + z) : (1.0 - z) / off;  // equal; each where it is accurate
  first = {1 - k * x * x, -k * x * y, -x};
  second = {-k * x * y, 1 - k * y * y, -y};
}

// With the rotation orthonormal again after the rounding of many products (Bjorck and Bowie, 1971).
inline Transform made_rigid(Transform t) {
  for (int round = 0; round < 2; ++round) {
    const Transform r = t;
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 3; ++c) {
        t(i, c) = 1.5 * r(i, c);
        for (int k = 0; k < 3; ++k) {
          const double gram = r(0, k) * r(0, c) + r(1, k) * r(1, c) + r(2, k) * r(2, c);
          t(i, c) -= 0.5 * r(i, k) * gram;
        }
      }
  }
  return t;
}

}  // namespace urdf
STILLREACH_END
