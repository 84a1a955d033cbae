// How far a ray goes in the polytope of the twists that a box of rates makes: the largest s with fixed + s twist = A z,
// z in the box. By duality that is the least of h(y) = sum of max(lower a'y, upper a'y) - fixed'y over y with twist'y =
// 1, a convex function that is linear piece by piece. The search goes down along edges where columns a lie in the plane
// y stands on, each time as far as h falls, through many pieces at once (the dual simplex method with bound flipping;
// Kirillova and others, 1979, Maros, 2003). Up to m - 1 columns lie in the plane (the basis), all others are at the
// bound that is farther along y. Bases are factored by orthogonal vectors, anew from the first column that differs, so
// that neither steps nor small singular values pile up errors.
#pragma once

#include "stillreach/bounded/careful.hpp"

STILLREACH_BEGIN

constexpr double kReached = 1e-13;  // relative residual that counts as none
constexpr double kLeaves = 1e-9;    // part of a column across a plane that is not rounding
constexpr double kAcross = 1e-13;   // likewise, of the direction of an edge
constexpr double kMissed = 100.0;   // times rounding, from which on a ray misses
constexpr double kApart = 1e-6;     // part of a column that the others of a basis leave, for it to start a search

// The problem and where the search is. Rows of `basis` are unit vectors: of the columns in the plane, what those before
// leave of each; last of the twist.
struct Ray {
  const double *fixed, *twist, *lower, *upper;  // bounds: k, of z
  int count;                                    // columns in the plane,
  int column[kRows];                            // which,
  double part[kRows];                           // their z,
  double basis[kRows][kStride], triangle[kRows][kRows];
  int fresh = 0;                      // columns whose vectors are right already
  double apart;                       // the least part that one of them is left with by those before it
  double y[kStride];                  // normal of the plane, twist'y = 1
  double *slope, *change, *distance;  // k: a'y, its derivative along the edge, and how far it is to the end of its side
  double noise;                       // a length that counts as none
};

// The residual that counts as none: rounding of the twist, and of the sum of what the joints contribute.
STILLREACH_INLINE double reached(const Box& b, double scale) {
  double largest = 0.0;
  for (int i = 0; i < b.k; ++i) largest = larger(largest, magnitude(b.z[i]) * b.length[i]);
  return kReached * scale + kRounding * largest;
}

// Factors the columns in the plane and the twist.
template <int M>
inline void factor_basis(Rows<M> m, const Box& b, Ray& ray) {
  ray.apart = 1.0;
  for (int j = ray.fresh; j <= ray.count; ++j) {
    const double* a = j < ray.count ? b.columns + ray.column[j] * kStride : ray.twist;
    double *q = ray.basis[j], along[kRows];
    for (int r = 0; r < kStride; ++r) q[r] = r < m() ? a[r] : 0.0;
    make_orthogonal(m, ray.basis, j, q, along);
    const double length = size_of(m, q);
    for (int i = 0; i < j; ++i) ray.triangle[i][j] = along[i];
    ray.triangle[j][j] = length;
    ray.apart = smaller(ray.apart, length / size_of(m, a));
    for (int r = 0; r < m(); ++r) q[r] /= length;
  }
  ray.fresh = ray.count;
}

// The plane that stands on the basis and is otherwise as near to y as can be.
template <int M>
inline void stand(Rows<M> m, Ray& ray) {
  const int rows = ray.count + 1;
  if (rows < m())
    make_orthogonal(m, ray.basis, rows, ray.y);
  else
    for (int r = 0; r < kStride; ++r) ray.y[r] = 0.0;
  const double last = 1.0 / ray.triangle[rows - 1][rows - 1];
  for (int r = 0; r < m(); ++r) ray.y[r] = madd(last, ray.basis[rows - 1][r], ray.y[r]);
}

// What columns at their bounds leave for the basis and the twist to do. Those without a bound give nothing.
template <int M>
inline void remainder(Rows<M> m, const Box& b, Ray& ray, double* rest) {
  double largest = size_of(m, ray.fixed);
  for (int r = 0; r < kStride; ++r) rest[r] = r < m() ? ray.fixed[r] : 0.0;
  for (int i = 0; i < b.k; ++i) {
    if (b.state[i] == 0) continue;
    const double z = b.state[i] > 0 ? ray.upper[i] : ray.lower[i];
    if (z == 0.0 || !is_finite(z)) continue;
    largest = larger(largest, magnitude(z) * b.length[i]);
    for (int r = 0; r < m(); ++r) rest[r] = madd(-b.columns[i * kStride + r], z, rest[r]);
  }
  ray.noise = 2.0 * kRounding * largest;
}

// Goes along the edge `along` for as long as h falls; the column that ends that enters the basis. False: it falls
// forever, and the search stays where it is.
template <int M>
inline bool follow(Rows<M> m, Box& b, const double* along, Ray& ray) {
  const double length = size_of(m, along), least = kAcross * length, flat = length * larger(least, ray.noise);
  double fall = length * length;
  multiply_columns(b.columns, b.k, along, ray.change);
  for (int i = 0; i < b.k; ++i) {
    const double towards = -b.state[i] * ray.change[i];
    const bool stops = towards > 0.0, endless = magnitude(b.state[i] > 0 ? ray.upper[i] : ray.lower[i]) == infinity();
    const double end = stops                        ? larger(b.state[i] * ray.slope[i], 0.0) / towards
                       : endless && b.state[i] != 0 ? 0.0
                                                    : infinity();
    ray.distance[i] = magnitude(towards) > least * b.length[i] ? end : infinity();
  }
  double at = 0.0;
  while (true) {
    int next = -1;
    double nearest = infinity();
    for (int i = 0; i < b.k; ++i)
      if (ray.distance[i] < nearest) {
        nearest = ray.distance[i];
        next = i;
      }
    if (next < 0) {
      for (int i = 0; i < b.k; ++i)
        if (b.state[i] * ray.slope[i] < 0.0) b.state[i] = static_cast<std::int8_t>(-b.state[i]);
      return false;
    }
    at = larger(at, nearest);
    fall -= magnitude(ray.change[next]) * (ray.upper[next] - ray.lower[next]);
    if (!(fall > flat)) {
      b.state[next] = 0;
      ray.column[ray.count++] = next;
      for (int r = 0; r < m(); ++r) ray.y[r] = madd(at, along[r], ray.y[r]);
      return true;
    }
    b.state[next] = static_cast<std::int8_t>(-b.state[next]);
    ray.distance[next] = infinity();
  }
}

// z of the columns in the plane, and s, which is returned, such that they and the twist make `rest`; refined once.
template <int M>
inline double solve_basis(Rows<M> m, const Box& b, double* rest, Ray& ray) {
  double s = 0.0, x[kRows];
  for (int j = 0; j < ray.count; ++j) ray.part[j] = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int j = ray.count; j >= 0; --j) {
      x[j] = dot(m, ray.basis[j], rest);
      for (int i = j + 1; i <= ray.count; ++i) x[j] = madd(-ray.triangle[j][i], x[i], x[j]);
      x[j] /= ray.triangle[j][j];
    }
    for (int j = 0; j <= ray.count; ++j) {
      const double* a = j < ray.count ? b.columns + ray.column[j] * kStride : ray.twist;
      for (int r = 0; r < m(); ++r) rest[r] = madd(-a[r], x[j], rest[r]);
    }
    for (int j = 0; j < ray.count; ++j) ray.part[j] += x[j];
    s -= x[ray.count];
  }
  return s;
}

// Takes out of the basis the column that is farthest outside its bounds, if there is one.
inline bool leave(Box& b, Ray& ray) {
  int worst = -1;
  double most = ray.noise;
  for (int j = 0; j < ray.count; ++j) {
    const int i = ray.column[j];
    const double off = larger(ray.part[j] - ray.upper[i], ray.lower[i] - ray.part[j]) * b.length[i];
    if (off > most) {
      most = off;
      worst = j;
    }
  }
  if (worst < 0) return false;
  const int i = ray.column[worst];
  b.state[i] = ray.part[worst] > ray.upper[i] ? 1 : -1;
  --ray.count, ray.fresh = worst;
  for (int j = worst; j < ray.count; ++j) ray.column[j] = ray.column[j + 1];
  return true;
}

// From where the search is to the least h, which is the largest s; infinite where the ray misses the polytope
// (negative) or does not end (positive). b.state holds the sides, 0 for the basis.
template <int M>
inline double lower_plane(Rows<M> m, Box& b, Ray& ray) {
  const int most = 4 * b.k + 40;
  for (int step = 0; step < most; ++step) {
    double rest[kStride];
    factor_basis(m, b, ray);
    stand(m, ray);
    remainder(m, b, ray, rest);
    ++b.iterations;
    double along[kStride];
    for (int r = 0; r < kStride; ++r) along[r] = rest[r];
    if (ray.count + 1 < m()) {
      make_orthogonal(m, ray.basis, ray.count + 1, along);
      const double length = size_of(m, along);
      if (length > ray.noise) {
        multiply_columns(b.columns, b.k, ray.y, ray.slope);
        if (follow(m, b, along, ray)) continue;
        if (length > kMissed * ray.noise) return -infinity();
      }
    }
    const double s = solve_basis(m, b, rest, ray);
    if (!leave(b, ray)) return s;
  }
  b.capped = true;
  return 0.0;
}

// Whether a bound is infinite. Then the least of the infinite part of h comes first: with ends of 1 in place of such
// bounds, and of 0 in place of the others. room: 2 k numbers.
inline bool endless(const Box& b, double* room) {
  bool any = false;
  for (int i = 0; i < b.k; ++i) {
    room[i] = b.lower[i] == -infinity() ? -1.0 : 0.0;
    room[b.k + i] = b.upper[i] == infinity() ? 1.0 : 0.0;
    any |= room[i] != 0.0 || room[b.k + i] != 0.0;
  }
  return any;
}

// Where the search starts: the plane of the basis in `ray`, else the one across `normal`, whose sides every column
// takes.
template <int M>
inline void start_ray(Rows<M> m, const double* normal, Box& b, Ray& ray) {
  const double along = dot(m, normal, ray.twist);
  const bool fits = along > 0.0;
  const double* from = fits ? normal : ray.twist;
  const double scale = 1.0 / (fits ? along : dot(m, ray.twist, ray.twist));
  for (int r = 0; r < kStride; ++r) ray.y[r] = r < m() ? from[r] * scale : 0.0;
  if (ray.count > 0) {
    factor_basis(m, b, ray);
    if (ray.apart > kApart)
      stand(m, ray);
    else
      ray.count = ray.fresh = 0;
  }
  multiply_columns(b.columns, b.k, ray.y, ray.slope);
  for (int i = 0; i < b.k; ++i) b.state[i] = ray.slope[i] > 0.0 ? 1 : -1;
  for (int j = 0; j < ray.count; ++j) b.state[ray.column[j]] = 0;
}

// The largest s, with its z in b.z and the sides of its columns in b.state; minus infinity where no s fits, infinity
// where all do. normal: of a plane that may be near.
template <int M>
inline STILLREACH_NOINLINE double end_of_ray(Rows<M> m, const double* normal, double* room, Box& b, Ray& ray) {
  start_ray(m, normal, b, ray);
  b.capped = false;
  if (endless(b, room)) {
    const double none[kStride] = {0, 0, 0, 0, 0, 0, 0, 0}, *fixed = ray.fixed;
    ray.fixed = none;
    ray.lower = room;
    ray.upper = room + b.k;
    const double s = lower_plane(m, b, ray);
    ray.fixed = fixed;
    if (s > kAcross) return infinity();
  }
  ray.lower = b.lower;
  ray.upper = b.upper;
  const double s = lower_plane(m, b, ray);
  for (int i = 0; i < b.k; ++i) {
    const double z = b.state[i] > 0 ? b.upper[i] : b.lower[i];
    b.z[i] = is_finite(z) ? z : clamp(0.0, b.lower[i], b.upper[i]);
  }
  for (int j = 0; j < ray.count; ++j)
    b.z[ray.column[j]] = clamp(ray.part[j], b.lower[ray.column[j]], b.upper[ray.column[j]]);
  return s;
}

STILLREACH_END
