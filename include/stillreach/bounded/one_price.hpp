// The dual of a priced problem (price.hpp) with one price, where rounding decides nothing: written once for a number
// and for lanes, so that both give the same bits. A step goes to the maximum of the quadratic piece at u, (A_F A_F' +
// kappa) u = c with kappa = 0 or |u| = Y. Halley's method on 1 / |u| as a function of kappa takes one factorisation a
// step, and u follows kappa by its power series. What remains, nearly dependent columns above all, is
// price_search.hpp's.
#pragma once

#include "stillreach/bounded/price.hpp"

STILLREACH_BEGIN

constexpr int kOnePriceSteps = 8;        // most pieces,
constexpr int kOnePriceRounds = 6;       // and factorisations on one of them
constexpr double kSeries = 0.09;         // square of the relative change of u up to which its series does
constexpr double kConverged = 1e-8;      // and from which on the next one is rounding
constexpr double kPieceCondition = 1e8;  // condition number of a damped Gram matrix that is trusted
constexpr double kTight = 4e-15;         // relative error of |u_g| that is rounding

// V: the variables, of one problem or one a lane.
template <int M, class V>
struct OnePrice {
  using T = typename V::Number;
  using Where = typename V::Where;
  V& v;
  const T* rhs;                              // zeros behind
  T most, inverse_most;                      // Y
  T longest, rhs_size;                       // (nearly) of the columns, and of rhs
  T u[kStride], kappa;                       // the multiplier, zeros behind, and its damping
  T iterations;                              // factorisations
  T residual[kStride];                       // rhs - A z(u)
  T slack;                                   // rounding of A'u
  typename V::Matrix f;                      // of the piece's matrix with the damping `at`
  T diagonal[kRows], at, condition, change;  // change: square of the relative change of u by the last step of kappa

  STILLREACH_INLINE OnePrice(V& variables, const T* b, T price, T trace)
      : v(variables),
        rhs(b),
        most(price),
        inverse_most(1.0 / price),
        longest(square_root(trace)),
        rhs_size(size_of(b)) {
    for (int r = 0; r < kStride; ++r) u[r] = residual[r] = fill<T>(0.0);
    kappa = iterations = slack = change = fill<T>(0.0);
  }

  static STILLREACH_INLINE T product(const T* a, const T* b) {
    T sum = fill<T>(0.0);
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum = madd(a[r], b[r], sum);
    return sum;
  }
  static STILLREACH_INLINE T size_of(const T* a) { return square_root(product(a, a)); }

  STILLREACH_INLINE void rates_of(const T* multiplier, T* target, T* left) {
    v.multiply(multiplier, target);
    v.cut(target);
    v.residual(rhs, v.z, left);
  }

  // Where the matrix is singular, or nearly, `at` becomes a little more.
  STILLREACH_INLINE void factor_piece(Where open) {
    const auto with = [&] {
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) f.gram[r][r] = diagonal[r] + at;
      return factor<M, T>(f);
    };
    condition = with();
    const Where poor = except(open, condition < fill<T>(1e12));
    if (any(poor)) {
      at = select(poor, larger(at, 1e-11 * longest * longest), at);
      condition = with();
    }
    iterations += select(open, fill<T>(1.0), fill<T>(0.0));
  }

  // Newton's step of kappa from `at` towards |x| = Y for x = (G + at)^-1 c, with Halley's correction, not past what is
  // sure. Makes x the multiplier there.
  STILLREACH_INLINE T damped_step(Where active, T size, T* x) {
    T w[kRows], y[kRows];
    solve<M, T>(f, x, w), solve<M, T>(f, w, y);
    const T square = size * size, q = product(x, w), p = product(w, w), inverse_q = 1.0 / q,
            inverse_square = 1.0 / square;
    const T newton = madd(size, inverse_most, fill<T>(-1.0)) * square * inverse_q;
    const T bend = 1.5 * (q * inverse_square - p * inverse_q);
    const T least = select(size < most * (1.0 - 1e-9), fill<T>(0.0), 0.2 * at);
    const T next = larger(at + newton / larger(madd(newton, bend, fill<T>(1.0)), fill<T>(0.25)), least);
    const T step = select(active, next - at, fill<T>(0.0));
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) x[r] =
        select(active, madd(step, madd(step, y[r], -w[r]), x[r]), x[r]);
    change = select(active, step * step * p * inverse_square, fill<T>(0.0));
    return select(active, next, at);
  }

  // To the maximum `next` of the piece, in the lanes of `open`: in one at least.
  STILLREACH_INLINE void solve_piece(Where open, T* next) {
    at = kappa;
    int round = 0;
    do {
      factor_piece(open);
      T x[kRows];
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) x[r] = madd(-at, u[r], residual[r]);
      solve<M, T>(f, x, x);
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) x[r] += u[r];
      const T size = size_of(x), was = change;
      const Where active = open & ((at > fill<T>(0.0)) | (size > most * (1.0 + kTight)));
      T found = at;
      change = fill<T>(0.0);
      if (any(active)) found = damped_step(active, size, x);
      change = select(open, change, was);
      kappa = select(open, found, kappa);
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) next[r] = select(open, x[r], next[r]);
      open = open & (change > fill<T>(kSeries));
      at = select(open, kappa, at);
    } while (++round < kOnePriceRounds && any(open));
    const T size = size_of(next), factor = most / size;
    const Where damped = kappa > fill<T>(0.0), some = size > fill<T>(0.0), over = size > most;
    const Where full = (damped & some) | over;
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) next[r] = select(full, next[r] * factor, next[r]);
  }

  // From u towards `next`: all the way in the lanes that are returned, else to where the dual is greatest between them.
  // Lanes in which rounding is all that is left to gain leave `live`.
  STILLREACH_INLINE Where climb(Where& live, T* next) {
    T way[kStride], left[kStride];
    for (int r = 0; r < kStride; ++r) way[r] = r < M ? next[r] - u[r] : fill<T>(0.0);
    const T start = product(way, residual);
    rates_of(next, v.next, left);
    const T end = product(way, left);
    Where top = live & (end >= -0.1 * start);
    if (any(except(live, top))) {
      const T noise = madd(longest, slack, 4e-15 * (rhs_size + longest * v.largest(v.z)));
      const T least = madd(noise, size_of(way), 1e-15 * size_of(next) * size_of(residual));
      top = top | (live & (end >= -least));
      const Where partly = except(live, top) & (start > least);
      live = top | partly;
      if (any(partly)) {
        v.multiply(way, v.speed);
        const T part = top_of_segment(v.k, v.target, v.speed, v.lower, v.upper, start, partly);
        for (int i = 0; i < v.k; ++i) {
          const T there = madd(part, v.speed[i], v.target[i]);
          v.side[i] = select(partly, side_of(v.side[i], there, v.lower[i], v.upper[i], fill<T>(0.0)), v.side[i]);
        }
        STILLREACH_UNROLL for (int r = 0; r < M; ++r) next[r] = select(partly, madd(part, way[r], u[r]), next[r]);
        rates_of(next, v.next, left);
      }
    }
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) {
      u[r] = next[r];
      residual[r] = left[r];
    }
    T* const old = v.target;
    v.target = v.next;
    v.next = old;
    return top;
  }

  // Newton's step for u and kappa together with the matrix at hand, added to the rates, which leave `left`: they keep
  // digits that A'u does not have.
  STILLREACH_INLINE void polish(Where done, const T* left) {
    T h[kStride], w[kRows], step = fill<T>(0.0);
    for (int r = 0; r < kStride; ++r) h[r] = r < M ? madd(-kappa, u[r], left[r]) : fill<T>(0.0);
    solve<M, T>(f, h, h);
    const Where damped = done & (kappa > fill<T>(0.0));
    if (any(damped)) {
      solve<M, T>(f, u, w);
      step = select(damped, madd(fill<T>(0.5), product(u, u) - most * most, product(u, h)) / product(u, w), step);
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) h[r] = select(damped, madd(-step, w[r], h[r]), h[r]);
    }
    kappa = select(damped, larger(kappa + step, fill<T>(0.0)), kappa);
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) u[r] = select(done, u[r] + h[r], u[r]);
    v.multiply(h, v.speed);
    v.move(done);
  }

  // The search starts at a multiplier, cut to |u| <= Y.
  STILLREACH_INLINE void begin_at(const T* multiplier) {
    const T size = size_of(multiplier), factor = most / size;
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) u[r] = select(size > most, multiplier[r] * factor, multiplier[r]);
  }

  // The damping of the answer, or 0 where its error is rounding.
  STILLREACH_INLINE T damping() const {
    const T size = larger(rhs_size, longest * v.largest(v.answer));
    return select(kappa * most > kRounding * size, kappa, fill<T>(0.0));
  }

  // From u, which is affordable, and kappa. Returns the lanes of `live` in which the answer is in v.answer and v.side.
  STILLREACH_INLINE Where search(Where live) {
    Where found = except(live, live);
    if (!any(live)) return found;
    T next[kStride];
    for (int r = 0; r < kStride; ++r) next[r] = fill<T>(0.0);
    rates_of(u, v.target, residual);
    v.start();
    v.classify(live, fill<T>(0.0));
    form_piece();
    for (int step = 0; step < kOnePriceSteps; ++step) {
      slack = 1e-15 * longest * size_of(u);
      solve_piece(live, next);
      const Where top = climb(live, next), moved = v.classify(live, slack), lower = except(live, top);
      const Where changed = moved | lower, settled = except(live, changed), small = change <= fill<T>(kConverged);
      const Where tight = settled & small;
      const Where done = tight & (condition < fill<T>(kPieceCondition));
      live = except(live, tight);
      found = found | done;
      if (any(done)) finish(done);
      if (!any(live)) break;
      if (any(changed)) form_piece();
    }
    return found;
  }

  STILLREACH_INLINE void form_piece() {
    v.form(f);
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) diagonal[r] = f.gram[r][r];
  }

  STILLREACH_INLINE void finish(Where done) {
    v.keep(done);
    polish(done, residual);
    const Where again = done & (condition >= fill<T>(kPlainCondition));
    if (!any(again)) return;
    T left[kStride];
    v.residual(rhs, v.answer, left);
    polish(again, left);
  }
};

// One problem.
template <int M>
struct Variables {
  using Number = double;
  using Where = bool;
  using Matrix = Factor;
  int k;
  const double *columns, *lower, *upper;
  double *target, *next, *z, *answer, *side, *speed;  // k each
  int* index;

  STILLREACH_INLINE void multiply(const double* u, double* to) const { multiply_columns(columns, k, u, to); }
  STILLREACH_INLINE void cut(const double* at) const {
    in_packs(k, [&](auto type, int i) {
      using P = decltype(type);
      put(z + i, larger(smaller(get<P>(at + i), get<P>(upper + i)), get<P>(lower + i)));
    });
  }
  STILLREACH_INLINE void residual(const double* rhs, const double* rates, double* to) const {
    residual_of(columns, nullptr, k, rhs, rates, to);
  }
  STILLREACH_INLINE double largest(const double* rates) const {
    double most = 0.0;
    for (int i = 0; i < k; ++i) most = larger(most, magnitude(rates[i]));
    return most;
  }
  STILLREACH_INLINE void start() const {
    for (int i = 0; i < k; ++i) side[i] = 0.0;
  }
  STILLREACH_INLINE bool classify(bool, double slack) const {
    bool changed = false;
    in_packs(k, [&](auto type, int i) {
      using P = decltype(type);
      const P was = get<P>(side + i),
              now = side_of(was, get<P>(target + i), get<P>(lower + i), get<P>(upper + i), fill<P>(slack));
      changed |= any(now != was);
      put(side + i, now);
    });
    return changed;
  }
  STILLREACH_INLINE void form(Matrix& f) const {
    int free = 0;
    for (int i = 0; i < k; ++i) {
      index[free] = i;
      free += side[i] == 0.0;
    }
    gram(Rows<M>{M}, columns, index, free, 0.0, f);
  }
  STILLREACH_INLINE void keep(bool) const {
    for (int i = 0; i < k; ++i) answer[i] = z[i];
  }
  STILLREACH_INLINE void move(bool) const {
    in_packs(k, [&](auto type, int i) {
      using P = decltype(type);
      const P old = get<P>(answer + i),
              now = larger(smaller(old + get<P>(speed + i), get<P>(upper + i)), get<P>(lower + i));
      put(answer + i, select(get<P>(side + i) == fill<P>(0.0), now, old));
    });
  }
};

STILLREACH_END
