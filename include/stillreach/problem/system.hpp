// From a tick's question to a plain least-squares problem over the working joints: columns a_i and right-hand side b in
// weighted units, scaled so that squares neither overflow nor vanish.
#pragma once

#include "stillreach/problem/workspace.hpp"

STILLREACH_BEGIN

struct System {
  int m;
  int k;                // working joints
  double rhs[kStride];  // R (twist - J fixed rates), zeros behind
  double unit_a;        // columns are divided by this power of two,
  double unit_b;        // and the right-hand side by this one
  int weighted;         // with a full joint weight: the joints' directions that have some,
  bool idle;            // and whether others without depend on each other
  bool full;            // a full joint weight is in use
  bool finite;          // false: something overflowed or is NaN; there is no problem to solve
};

STILLREACH_INLINE double power_of_two_near(double a) {
  int e = 0;
  (void)STILLREACH_LIBRARY(frexp)(a, &e);
  return STILLREACH_LIBRARY(ldexp)(1.0, e - 1);
}

constexpr double kNothing = 1e-290;  // a twist of less is none: bounds in its units would overflow

// 1 where `a` may be squared and summed, else the power of two to divide by.
STILLREACH_INLINE double scaling_unit(double a) {
  return a == 0.0 || (a > 1e-60 && a < 1e60) ? 1.0 : power_of_two_near(a);
}

// y = R x, R upper triangular or null for the identity.
template <class T, int M>
STILLREACH_INLINE void apply_rows(Rows<M> m, const double* R, const T* x, T* y) {
  const int rows = m();
  STILLREACH_UNROLL for (int r = 0; r < rows; ++r) {
    if (!R) {
      y[r] = x[r];
      continue;
    }
    T sum = fill<T>(R[r * rows + r]) * x[r];
    for (int c = r + 1; c < rows; ++c) sum = madd(fill<T>(R[r * rows + c]), x[c], sum);
    y[r] = sum;
  }
}

// Where a joint has one rate left, and moves.
template <class T>
STILLREACH_INLINE Where<T> moves_fixed(T lower, T upper) {
  const Where<T> moves = lower != fill<T>(0.0), works = lower < upper;
  return except(moves, works);
}

// Working joints are those with lower < upper that are not held. rates[i] of the others is set to their bound or is
// what the caller wrote for held joints.
inline void find_working_joints(const Problem& p, const std::int8_t* held, Workspace& w, int& k, double* rates) {
  k = 0;
  for (int i = 0; i < p.n; ++i) {
    if (p.lower[i] < p.upper[i]) {
      if (!held || !held[i]) w.joint[k++] = i;
    } else {
      rates[i] = p.lower[i];
    }
  }
}

// The full joint weight of the working joints: k x k, row-major, into w.weight. Scaled rates are in joint units
// already.
inline void gather_joint_weight(const Problem& p, int k, Workspace& w) {
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < k; ++j) w.weight[i * k + j] = p.metric.joints[std::ptrdiff_t{w.joint[i]} * p.n + w.joint[j]];
}

// Cholesky factor (lower, row-major, count x count) of the rows and columns `index` (null: all) of the k x k `weight`.
inline void factor_weight(int k, const double* weight, const int* index, int count, double* L) {
  for (int i = 0; i < count; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = weight[(index ? index[i] : i) * k + (index ? index[j] : j)];
      for (int c = 0; c < j; ++c) sum = madd(-L[i * count + c], L[j * count + c], sum);
      L[i * count + j] = i == j ? square_root(sum) : sum / L[j * count + j];
    }
}

// In place, on `count` interleaved vectors: solves L y = x or, transposed, L' y = x.
inline void solve_triangle(int k, const double* L, bool transposed, int count, double* x) {
  for (int step = 0; step < k; ++step) {
    const int i = transposed ? k - 1 - step : step;
    for (int c = 0; c < count; ++c) {
      double sum = x[i * count + c];
      if (transposed)
        for (int j = i + 1; j < k; ++j) sum = madd(-L[j * k + i], x[j * count + c], sum);
      else
        for (int j = 0; j < i; ++j) sum = madd(-L[i * k + j], x[j * count + c], sum);
      x[i * count + c] = sum / L[i * k + i];
    }
  }
}

constexpr double kEndless = 2.0;  // [rad/s, m/s] what a joint without a rate limit counts as

// The second largest rate limit in weighted units (the largest where there is no second): one generous joint changes
// nothing.
struct TypicalRate {
  double largest = 0.0, second = 0.0;
  STILLREACH_INLINE void add(const Metric& metric, int n, int i, double limit) {
    const double own = metric.joints ? square_root(metric.joints[std::ptrdiff_t{i} * n + i]) : 1.0;
    const double rate = (limit < infinity() ? limit : kEndless) * own / (metric.columns ? metric.columns[i] : 1.0);
    second = larger(second, smaller(largest, rate));
    largest = larger(largest, rate);
  }
  STILLREACH_INLINE double value() const { return second > 0.0 ? second : largest; }
};

inline double typical_rate(int n, const double* lower, const double* upper, const Metric& metric) {
  TypicalRate typical;
  for (int i = 0; i < n; ++i)
    if (lower[i] < upper[i]) typical.add(metric, n, i, larger(magnitude(lower[i]), magnitude(upper[i])));
  return typical.value();
}

// a = scale R J_i, with zeros behind.
template <int M>
STILLREACH_INLINE void weighted_column(Rows<M> m, const double* R, const double* column, double scale, double* a) {
  if (!R && m() == 6) {
    const Pack s = broadcast(scale), head = load(column) * s, tail = load_pair(column + 4) * s;
    store(a, head);
    store(a + 4, tail);
    return;
  }
  apply_rows(m, R, column, a);
  for (int r = 0; r < m(); ++r) a[r] *= scale;
  for (int r = m(); r < kStride; ++r) a[r] = 0.0;
}

// The largest finite bound of the joints with lower < upper, in joint units: damping keeps the units of J J'.
inline double reference_extent(const Problem& p) {
  double reference = 0.0;
  for (int i = 0; i < p.n; ++i) {
    if (!(p.lower[i] < p.upper[i])) continue;
    const double extent = larger(p.upper[i], -p.lower[i]), e = p.metric.units ? extent / p.metric.units[i] : extent;
    if (e < infinity() && e > reference) reference = e;
  }
  return reference;
}

// A bound beside the reference, as the damping laws scale the joint's rate.
STILLREACH_INLINE double relative_extent(const Problem& p, int i, double extent, double reference) {
  if (!(reference > 0.0 && extent < infinity())) return 1.0;
  return (p.metric.units ? extent / p.metric.units[i] : extent) / reference;
}

// Brings columns and right-hand side into the range where squares can be summed.
inline void rescale(System& s, double size_a, double size_b, Workspace& w) {
  s.unit_a = scaling_unit(size_a);
  s.unit_b = scaling_unit(size_b);
  for (int j = 0; j < kStride * s.k; ++j) w.columns[j] /= s.unit_a;
  for (int r = 0; r < s.m; ++r) s.rhs[r] /= s.unit_b;
  for (int j = 0; j < s.k; ++j) w.scale[j] = w.scale[j] / s.unit_a * s.unit_b;
}

// Whether a fixed joint moves.
inline bool any_moves(const Problem& p) {
  if (p.n < 4) {
    bool moves = false;
    for (int i = 0; i < p.n; ++i) moves |= moves_fixed(p.lower[i], p.upper[i]);
    return moves;
  }
  Mask moves = {};
  for (int next = 0; next < p.n; next += 4) {  // the last four may overlap those before
    const int i = next + 4 <= p.n ? next : p.n - 4;
    const Pack low = load(p.lower + i), high = load(p.upper + i);
    moves |= moves_fixed(low, high);
  }
  return bits_of(moves) != 0;
}

// Right-hand side and columns. extent: n bounds of the damping laws (rate = extent u), or null.
template <int M>
inline System assemble(Rows<M> m, const Problem& p, const double* rates, const std::int8_t* held, int k,
                       const double* extent, Workspace& w) {
  System s;
  s.m = m();
  s.k = k;
  s.weighted = k;
  s.idle = false;
  s.full = p.metric.joints != nullptr;
  s.unit_a = 1.0;
  s.unit_b = 1.0;
  double raw[kRows];
  for (int r = 0; r < m(); ++r) raw[r] = p.twist[r];
  if (held || any_moves(p))
    for (int i = 0; i < p.n; ++i)
      if ((!(p.lower[i] < p.upper[i]) || (held && held[i])) && rates[i] != 0.0)
        for (int r = 0; r < m(); ++r) raw[r] = madd(-p.jacobian[i * m() + r], rates[i], raw[r]);
  apply_rows(m, p.metric.rows, raw, s.rhs);
  double size = 0.0, nearby = 0.0;
  for (int r = 0; r < m(); ++r) size += magnitude(s.rhs[r]);
  for (int r = size < kNothing ? 0 : m(); r < kStride; ++r) s.rhs[r] = 0.0;
  if (size < kNothing) size = 0.0;
  if (p.reference)
    for (int j = 0; j < k; ++j) nearby += magnitude(p.reference[w.joint[j]]);
  if (size > 0.0 && size < 1e-60)  // a bound that leaves no rest moves the right-hand side, too
    for (int j = 0; j < k; ++j) nearby += magnitude(clamp(0.0, p.lower[w.joint[j]], p.upper[w.joint[j]]));

  const double reference = extent ? reference_extent(p) : 0.0;
  Pack sum = broadcast(0.0);
  for (int j = 0; j < k; ++j) {
    const int i = w.joint[j];
    double scale = p.metric.columns ? p.metric.columns[i] : 1.0;
    if (extent) scale *= relative_extent(p, i, extent[i], reference);
    w.scale[j] = scale;
    double* a = w.columns + j * kStride;
    weighted_column(m, p.metric.rows, p.jacobian + i * m(), scale, a);
    sum += magnitude(load(a)) + magnitude(load(a + 4));
  }
  const double total = (sum[0] + sum[2]) + (sum[1] + sum[3]);
  if (nearby * total > size && is_finite(nearby * total))
    size = nearby * total;  // the reference moves the right-hand side
  s.finite = is_finite(total) && is_finite(size);
  if (s.finite && (scaling_unit(total) != 1.0 || scaling_unit(size) != 1.0)) rescale(s, total, size, w);
  return s;
}

// e = twist - J rates. P: Problem or LaneProblem.
template <class T, int M, class P>
STILLREACH_INLINE void residual_by_rows(Rows<M> m, const P& p, const T* rates, T* e) {
  const int rows = m();
  STILLREACH_UNROLL for (int r = 0; r < rows; ++r) e[r] = p.twist[r];
  for (int i = 0; i < p.n; ++i)
    STILLREACH_UNROLL for (int r = 0; r < rows; ++r) e[r] = madd(p.jacobian[i * rows + r], -rates[i], e[r]);
}
template <int M>
STILLREACH_INLINE void task_residual(Rows<M> m, const Problem& p, const double* rates, double* e) {
  if (m() == 6) {  // two packs that overlap
    Pack head = load(p.twist), tail = load(p.twist + 2);
    for (int i = 0; i < p.n; ++i) {
      const Pack rate = broadcast(-rates[i]);
      head = madd(load(p.jacobian + 6 * i), rate, head);
      tail = madd(load(p.jacobian + 6 * i + 2), rate, tail);
    }
    store(e, head);
    store(e + 2, tail);
    return;
  }
  residual_by_rows(m, p, rates, e);
}

constexpr double kCompensated = 1e-9;  // relative task error from which on a runaway joint counts as not compensated

// The largest entry of what the fixed joints do to the task. P: Problem or LaneProblem.
template <class T, int M, class P>
STILLREACH_INLINE T drift_of(Rows<M> m, const P& p) {
  T drift = fill<T>(0.0);
  for (int i = 0; i < p.n; ++i) {
    const Where<T> moves = moves_fixed(p.lower[i], p.upper[i]);
    if (!any(moves)) continue;
    for (int r = 0; r < m(); ++r)
      drift = larger(drift, select(moves, magnitude(p.jacobian[i * m() + r] * p.lower[i]), fill<T>(0.0)));
  }
  return drift;
}

// Where a fixed joint moves, and the task is not met: the others may be unable to make up for it.
template <int M>
inline bool fault_not_compensated(Rows<M> m, const Problem& p, const Answer& out) {
  if (!any_moves(p)) return false;
  const double drift = drift_of<double>(m, p);
  return drift != 0.0 && largest_of(m, out.residual) > kCompensated * drift;
}

// -1 at the lower bound, 1 at the upper one, 2 fixed, 0 free; as in Answer::active.
STILLREACH_INLINE std::int8_t bound_code(double rate, double lower, double upper) {
  const int top = rate >= upper - 1e-9 * magnitude(upper), bottom = rate <= lower + 1e-9 * magnitude(lower);  // inf: no
  return static_cast<std::int8_t>(lower < upper ? top - bottom : 2);
}

// bound_code() of every joint. True where some working joint is at a bound.
inline bool bound_codes(int n, const double* rates, const double* lower, const double* upper, std::int8_t* codes) {
  bool saturated = false;
  if (n < 4) {
    for (int i = 0; i < n; ++i) {
      codes[i] = bound_code(rates[i], lower[i], upper[i]);
      saturated |= (codes[i] & 1) != 0;
    }
    return saturated;
  }
  // bit l to byte l
  const auto bytes = [](int bits) { return (static_cast<unsigned>(bits) * 0x204081u) & 0x1010101u; };
  for (int next = 0; next < n; next += 4) {  // the last four may overlap those before
    const int i = next + 4 <= n ? next : n - 4;
    const Pack rate = load(rates + i), low = load(lower + i), high = load(upper + i), small = broadcast(1e-9);
    const Mask works = low < high;
    const int top = bits_of(works & (rate >= high - small * magnitude(high)));
    const int bottom = bits_of(works & (rate <= low + small * magnitude(low)));
    const unsigned code = bytes(top & ~bottom) | bytes(bottom & ~top) * 255 | bytes(~bits_of(works) & 15) * 2;
    for (int l = 0; l < 4; ++l) codes[i + l] = static_cast<std::int8_t>(code >> 8 * l);
    saturated |= top != bottom;
  }
  return saturated;
}

// What every law reports once its rates stand: residual, weighted task error, active bounds, saturation.
template <int M>
inline void report(Rows<M> m, const Problem& p, Answer& out) {
  double e[kRows], weighted[kRows];
  task_residual(m, p, out.rates, e);
  const bool saturated = bound_codes(p.n, out.rates, p.lower, p.upper, out.active);
  apply_rows(m, p.metric.rows, e, weighted);
  for (int r = 0; r < m(); ++r) out.residual[r] = e[r];
  const double unit = scaling_unit(largest_of(m, weighted));
  if (unit != 1.0)
    for (int r = 0; r < m(); ++r) weighted[r] /= unit;
  const double sum = dot(m, weighted, weighted);
  out.task_error = sum == sum ? square_root(sum) * unit : infinity();  // NaN: numbers that overflow
  if (saturated) out.status |= SATURATED;
  if (fault_not_compensated(m, p, out)) out.status |= FAULT_NOT_COMPENSATED;
}

STILLREACH_END
