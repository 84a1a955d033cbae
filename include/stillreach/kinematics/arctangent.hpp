// The angle of a direction in the first quadrant, in arithmetic of its own: every platform gives the same bits.
#pragma once

#include "stillreach/simd/scalar.hpp"

STILLREACH_BEGIN

// atan2(y, x) of y, x >= 0 that are not both 0, to about one unit in the last place: of 0, atan(1/2) and pi / 4 a near
// one, and a polynomial on [-0.4142, 0.4142] that errs least (by Remez's exchange; 1.3e-18 relative, with these
// coefficients).
inline double first_quadrant_angle(double y, double x) {
  const double small = smaller(x, y), large = larger(y, x);  // a NaN stays one
  double t, base = 0.0, base_rest = 0.0;
  if (small <= 0.4142 * large) {
    t = small / large;
  } else if (small <= 0.7208 * large) {
    t = madd(2.0, small, -large) / madd(2.0, large, small);
    base = 0x1.dac670561bb4fp-2;
    base_rest = 0x1.a2b7f222f65e2p-56;
  } else {
    t = (small - large) / (small + large);
    base = 0x1.921fb54442d18p-1;
    base_rest = 0x1.1a62633145c07p-55;
  }
  const double z = t * t;
  double p = -0x1.255b47f461843p-6;
  p = madd(p, z, 0x1.37ce236ffbf83p-5);
  p = madd(p, z, -0x1.9ccf800c0e7ecp-5);
  p = madd(p, z, 0x1.df0e805b1499ep-5);
  p = madd(p, z, -0x1.10eba8cab01aap-4);
  p = madd(p, z, 0x1.3b11179540a3dp-4);
  p = madd(p, z, -0x1.745cf8c3741fcp-4);
  p = madd(p, z, 0x1.c71c70e50e316p-4);
  p = madd(p, z, -0x1.24924922aa4d9p-3);
  p = madd(p, z, 0x1.99999999957cdp-3);
  p = madd(p, z, -0x1.555555555553dp-2);
  const double angle = base + (t + madd(p * z, t, base_rest));
  return y > x ? 0x1.921fb54442d18p+0 - (angle - 0x1.1a62633145c07p-54) : angle;
}

STILLREACH_END
