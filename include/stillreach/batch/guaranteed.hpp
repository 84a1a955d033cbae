// The speed that the tool reaches in every direction, before and after each loss of joints: the distance from 0 to the
// nearest facet of the velocities J rates.
//
// A facet is parallel to m - 1 columns. One depth-first pass over their sets reflects all columns so that they lose
// the coordinate along each chosen one; what a column has left at the end is what its joint adds to the speed across
// the facet. A failed joint adds nothing, so the worst set of a size takes the largest parts of each facet away.
#pragma once

#include "stillreach/batch/relative.hpp"

STILLREACH_BEGIN

constexpr double kDependentColumn = 1e-9;  // what chosen columns leave of a column, relative
constexpr double kNoSpeed = 1e-12;         // of the speed of all joints: rounding

struct FacetPass {
  const LossBatch* batch;
  const LossMemory* memory;
  const Wide* lengths;  // of the columns
  Wide* whole;
};

// One facet. across: what each joint adds to the speed across it. valid: the lanes that have it.
inline void take_facet(const FacetPass& p, const Wide* across, Lanes valid, Wide* largest) {
  const LossBatch& b = *p.batch;
  const LossMemory& w = *p.memory;
  const int n = b.arm.n;
  Wide total = wide(0.0);
  for (int s = 0; s < b.sizes; ++s) largest[s] = wide(0.0);
  for (int i = 0; i < n; ++i) {
    Wide part = magnitude(across[i]);
    total += part;
    for (int s = 0; s < b.sizes; ++s) {
      const Wide more = larger(largest[s], part);
      part = smaller(largest[s], part);
      largest[s] = more;
    }
  }
  const Wide far = wide(infinity());
  const auto take = [&](Wide speed, Wide& least) { least = smaller(select(valid, speed, far), least); };
  take(total, *p.whole);
  for (int i = 0; i < n; ++i) take(total - magnitude(across[i]), w.joint[i]);
  Wide left = total;
  for (int s = 0; s < b.sizes; ++s) {
    left = left - largest[s];
    take(left, w.worst[s]);
  }
  for (std::ptrdiff_t f = 0; b.every && f < b.count; ++f) {
    Wide rest = total;
    for (int s = 0; s < b.sizes && b.sets[f * b.sizes + s] >= 0; ++s)
      rest = rest - magnitude(across[b.sets[f * b.sizes + s]]);
    take(rest, w.every[f]);
  }
}

// Chooses a column from `first` on, then the others, until one coordinate is left. columns: of all joints, d numbers
// each, 0 for chosen ones.
template <int D>
inline void choose_column(const FacetPass& p, int first, const Wide* columns, Lanes valid, Wide* more) {
  const int n = p.batch->arm.n;
  if constexpr (D == 1) {
    take_facet(p, columns, valid, more);
  } else {
    for (int i = first; i <= n - (D - 1); ++i) {
      Wide axis[kRows];
      for (int c = 0; c < D; ++c) axis[c] = columns[i * D + c];
      const Wide size = length_of<D>(D, axis);
      const Lanes here = valid & (size > kDependentColumn * p.lengths[i]);
      if (!any(here)) continue;
      const Wide factor = mirror<D>(D, size, axis);
      for (int j = 0; j < n; ++j) reflect<D>(D, axis, factor, columns + j * D, more + j * (D - 1));
      for (int c = 0; c < D - 1; ++c) more[i * (D - 1) + c] = wide(0.0);
      choose_column<D - 1>(p, i + 1, more, here, more + n * (D - 1));
    }
  }
}

template <int M>
STILLREACH_INLINE void choose_first(Rows<M>, const FacetPass& p, const Wide* columns, Wide* more) {
  choose_column<M>(p, 0, columns, every_lane(), more);
}

// Rows first to last - 1.
inline void guaranteed_rows(const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles) {
  const int n = b.arm.n, m = b.m;
  each_loss_row(b, first, last, doubles, [&](const LossMemory& w) {
    const Wide far = wide(infinity());
    Wide whole = far, span = wide(0.0), *lengths = w.more, *more = w.more + n;
    for (int i = 0; i < n; ++i) {
      Wide* column = w.columns + i * m;
      for (int r = 0; r < m; ++r) column[r] = column[r] * wide(b.scales[r] * b.rates[i]);
      lengths[i] = length_of<0>(m, column);
      span += lengths[i];
      w.joint[i] = far;
    }
    for (int s = 0; s < b.sizes; ++s) w.worst[s] = far;
    for (std::ptrdiff_t f = 0; b.every && f < b.count; ++f) w.every[f] = far;
    const FacetPass pass{&b, &w, lengths, &whole};
    with_rows(m, [&](auto rows) { choose_first(rows, pass, w.columns, more); });
    const Wide rounding = kNoSpeed * span;
    const auto end = [&](Wide speed) { return select((speed < far) & (speed > rounding), speed, wide(0.0)); };
    for (int i = 0; i < n; ++i) w.joint[i] = end(w.joint[i]);
    for (int s = 0; s < b.sizes; ++s) w.worst[s] = end(w.worst[s]);
    for (std::ptrdiff_t f = 0; b.every && f < b.count; ++f) w.every[f] = end(w.every[f]);
    return end(whole);
  });
}

STILLREACH_END
