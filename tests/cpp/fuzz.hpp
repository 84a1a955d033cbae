// Hostile numbers for the kernels: extreme scales, signed zeros, subnormal numbers, NaN and infinity, bounds of any
// kind.
#pragma once

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "chains.hpp"
#include "check.hpp"

using stillreach::kernel;

using Numbers = std::vector<double>;
using Codes = std::vector<std::int8_t>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline Random rng(1);
inline int below(int n) { return rng.below(n); }
inline double between(double low, double high) { return rng.between(low, high); }
inline double decade(double low, double high) { return std::pow(10.0, between(low, high)); }

inline double special(bool with_nan) {
  static const double values[] = {0.0,
                                  1.0,
                                  5e-324,
                                  2.2250738585072014e-308,
                                  1e-310,
                                  1e-200,
                                  1e-160,
                                  1e-154,
                                  1e-60,
                                  1e60,
                                  1e100,
                                  1e150,
                                  1e154,
                                  1e160,
                                  1e200,
                                  1e300,
                                  1.7976931348623157e308,
                                  1e-16,
                                  1e16,
                                  0.5,
                                  1.0 + 0x1p-52,
                                  3.0};
  if (with_nan && below(30) == 0) return below(2) ? kNan : below(2) ? kInfinity : -kInfinity;
  const double value = values[below(sizeof values / sizeof *values)];
  return below(2) ? value : -value;
}

// How the numbers of one vector are drawn.
struct Style {
  int kind;
  double scale;
  bool with_nan;
};
inline Style any_style(bool with_nan) {
  return {below(6), below(3) ? 1.0 : decade(-310, 308), with_nan && below(6) == 0};
}
inline double number(const Style& style) {
  switch (style.kind) {
    case 3: return special(style.with_nan);
    case 4: return below(4) ? between(-1, 1) : special(style.with_nan);
    case 5: return below(5) - 2;
    default: return style.scale * between(-1, 1);
  }
}
inline Numbers numbers(std::size_t count, bool with_nan) {
  const Style style = any_style(with_nan);
  Numbers made(count);
  for (double& a : made) a = number(style);
  return made;
}

inline bool finite(const double* a, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(a[i])) return false;
  return true;
}
inline bool finite(const Numbers& a) { return finite(a.data(), a.size()); }

// Bounds of n joints, also without 0 in between; `legal`: each pair leaves a rate.
inline void any_bounds(int n, bool legal, double* lower, double* upper) {
  const int mode = below(7);
  const double scale = below(3) ? 1.0 : decade(-320, 308);
  for (int i = 0; i < n; ++i) {
    double a = -between(0, 1) * scale, b = between(0, 1) * scale;
    if (mode == 1 || (mode == 2 && below(2))) a = -kInfinity;
    if (mode == 1 || (mode == 2 && below(2))) b = kInfinity;
    if (mode == 3 || (mode == 5 && below(2))) a = b = below(2) ? 0.0 : number({0, scale, false});
    if (mode == 4) {
      a = special(false);
      b = special(false);
    }
    if (mode == 6) {
      a = between(-1, 1) * scale;
      b = below(2) ? std::nextafter(a, kInfinity) : a + std::fabs(a) * 1e-9;
    }
    if (below(4) == 0) a = 0.0;
    if (below(6) == 0) b = 0.0;
    if (a > b) std::swap(a, b);
    if (!legal && below(5) == 0) {
      a = number({4, 1.0, true});
      b = number({4, 1.0, true});
    }
    lower[i] = a;
    upper[i] = b;
  }
}
inline bool leave_room(const double* lower, const double* upper, int n) {
  for (int i = 0; i < n; ++i)
    if (!(lower[i] <= upper[i] && lower[i] < kInfinity && upper[i] > -kInfinity)) return false;
  return true;
}

// Units and weights, often none.
struct Weights {
  Numbers rows, units, columns, joints;
  Weights(int m, int n) {
    if (below(3)) return;
    if (below(2)) {
      rows.assign(m * m, 0.0);
      for (int r = 0; r < m; ++r)
        for (int c = r; c < m; ++c)
          rows[r * m + c] = (r == c ? between(0.1, 2) : between(-1, 1)) * (below(8) ? 1.0 : decade(-75, 75));
    }
    if (below(2)) return;
    const double scale = below(2) ? 1.0 : decade(-150, 150);
    for (int i = 0; i < n; ++i) {
      units.push_back(below(2) ? 1.0 : decade(-6, 6));
      columns.push_back(units[i] / std::sqrt(between(0.1, 10) * scale));
    }
    if (below(2)) return;
    const Numbers a = rng.vector(n * n, 1.0);  // positive definite: A A' + something
    const double more = below(2) ? 0.1 : 1e-14;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        double sum = i == j ? more : 0.0;
        for (int k = 0; k < n; ++k) sum += a[i * n + k] * a[j * n + k];
        joints.push_back(sum);
      }
    columns = units;
  }
  stillreach::Metric view() const {
    const auto at = [](const Numbers& v) { return v.empty() ? nullptr : v.data(); };
    return {at(rows), at(units), at(columns), at(joints)};
  }
};

inline stillreach::LawSettings any_law() {
  stillreach::LawSettings law{static_cast<stillreach::LawKind>(below(4)),
                              static_cast<stillreach::DampingKind>(below(3)),
                              static_cast<stillreach::NormKind>(below(2)),
                              below(3)   ? between(0, 1)
                              : below(2) ? decade(-310, 308)
                                         : 0.0,
                              below(4) ? 1e-10 : decade(-320, -1e-9),
                              below(stillreach::kParts + 1),
                              {},
                              {},
                              -1,
                              0.0,
                              0.0};
  for (int g = 0; g < law.parts; ++g) law.price[g] = below(3) ? decade(0, 3) : decade(-308, 308);
  for (int r = 0; r < 6 && law.parts > 0; ++r) law.part[r] = static_cast<std::int8_t>(below(law.parts));
  if (law.parts > 1 && below(2)) {
    law.capped = below(law.parts);
    law.ceiling = decade(-3, 3);
    law.beyond = law.price[law.capped] * decade(0, 3);
  }
  return law;
}

// An arm of any placements, axes and scale.
struct AnyArm {
  stillreach::ArmMemory memory;
  stillreach::ArmView view = memory.view();
  explicit AnyArm(int n) : memory(any(n)) {}
  static stillreach::ArmMemory any(int n) {
    const double scale = below(5) ? 1.0 : decade(-12, 12);
    const bool turned = below(5) != 0;
    Numbers placements(16 * (n + 1), 0.0), axes(3 * n, 0.0);
    std::vector<stillreach::JointKind> kinds(n);
    for (int i = 0; i <= n; ++i) {
      double* T = &placements[16 * i];
      T[15] = 1.0;
      rotation(turned, T);
      for (int r = 0; r < 3; ++r) T[4 * r + 3] = below(3) ? between(-1, 1) * scale : 0.0;
    }
    for (int i = 0; i < n; ++i) {
      axes[3 * i + below(3)] = below(2) ? 1.0 : -1.0;
      kinds[i] = below(5) ? stillreach::JointKind::REVOLUTE : stillreach::JointKind::PRISMATIC;
    }
    return {kinds, placements.data(), axes.data()};
  }
  // A rotation into the upper left of a row-major 4 x 4 matrix, often by quarter turns.
  static void rotation(bool turned, double* T) {
    const auto angle = [turned] { return !turned ? 0.0 : below(3) ? between(-3, 3) : below(4) * kPi / 2; };
    const double a = angle(), b = angle(), c = angle();
    const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b), cc = std::cos(c),
                 sc = std::sin(c);
    const double R[3][3] = {{ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc},
                            {sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc},
                            {-sb, cb * sc, cb * cc}};
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s < 3; ++s) T[4 * r + s] = R[r][s];
  }
};

// Memory of one solve, exactly as long as asked for and full of rubbish.
struct SolveMemory : stillreach::WorkspaceMemory {
  SolveMemory(int n, bool full) : WorkspaceMemory(n, full) {
    const stillreach::Memory to = view();
    std::fill_n(to.doubles, kernel().workspace_doubles(n, full), kNan);
    std::fill_n(to.ints, kernel().workspace_ints(n), 1 << 30);
    std::fill_n(to.bytes, kernel().workspace_bytes(n), std::int8_t{99});
  }
};

// A check whose first failures print the numbers of their case, which text() puts into words.
template <class Text>
void expect(bool holds, const char* what, const Text& text) {
  if (holds) return;
  if (++failures() <= 20) std::fprintf(stderr, "does not hold: %s: %s\n", what, text().c_str());
}
inline std::string shown(const char* name, const double* a, int count) {
  std::string text = std::string(" ") + name + " [";
  char one[40];
  for (int i = 0; i < count && i < 14; ++i) {
    std::snprintf(one, sizeof one, "%.17g,", a[i]);
    text += one;
  }
  return text + "]";
}
inline std::string shown(const stillreach::LawSettings& law) {
  char text[160];
  std::snprintf(text, sizeof text, "law %d damping %d norm %d kappa %g rank %g", static_cast<int>(law.kind),
                static_cast<int>(law.damping), static_cast<int>(law.norm), law.kappa, law.rank_tolerance);
  return text;
}
