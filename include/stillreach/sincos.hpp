// Sine and cosine of many angles at once: reduction by pi/2 in three parts (Cody and Waite, 1980), Taylor polynomials on
// [-pi/4, pi/4]. Absolute error below 3e-16 up to 8e5 rad; larger angles go to the C library.
#pragma once

#include "scalar.hpp"

STILLREACH_BEGIN

constexpr double kLargestReducedAngle = 8.0e5;

STILLREACH_INLINE void sincos(Pack x, Pack& sine, Pack& cosine) {
  const Pack magic = broadcast(0x1.8p52);
  const Pack shifted = madd(x, broadcast(0.63661977236758134308), magic);  // 2 / pi
  const Pack k = shifted - magic;
  Pack r = madd(k, broadcast(-0x1.921fb544p0), x);   // pi/2, first 33 bits,
  r = madd(k, broadcast(-0x1.0b4611a6p-34), r);      // next 33 bits,
  r = madd(k, broadcast(-0x1.3198a2e037073p-69), r); // and the rest
  const Pack z = r * r;
  Pack s = broadcast(1.0 / 355687428096000.0);        // 1/17!
  s = madd(s, z, broadcast(-1.0 / 1307674368000.0));  // -1/15! ...
  s = madd(s, z, broadcast(1.0 / 6227020800.0));
  s = madd(s, z, broadcast(-1.0 / 39916800.0));
  s = madd(s, z, broadcast(1.0 / 362880.0));
  s = madd(s, z, broadcast(-1.0 / 5040.0));
  s = madd(s, z, broadcast(1.0 / 120.0));
  s = madd(s, z, broadcast(-1.0 / 6.0));
  s = madd(s * z, r, r);
  Pack c = broadcast(1.0 / 20922789888000.0);         // 1/16! ...
  c = madd(c, z, broadcast(-1.0 / 87178291200.0));
  c = madd(c, z, broadcast(1.0 / 479001600.0));
  c = madd(c, z, broadcast(-1.0 / 3628800.0));
  c = madd(c, z, broadcast(1.0 / 40320.0));
  c = madd(c, z, broadcast(-1.0 / 720.0));
  c = madd(c, z, broadcast(1.0 / 24.0));
  c = madd(c * z, z, madd(z, broadcast(-0.5), broadcast(1.0)));
  const Mask quadrant = (Mask)shifted;  // the low bits of the shifted sum are k
  const Mask swap = (quadrant & 1) != 0;
  const Mask sine_sign = (quadrant & 2) << 62, cosine_sign = ((quadrant + 1) & 2) << 62;
  sine = (Pack)((Mask)(swap ? c : s) ^ sine_sign);
  cosine = (Pack)((Mask)(swap ? s : c) ^ cosine_sign);
}

// q, sine, cosine: count values each. Angles outside the reduction's range, and NaN, go to the C library.
inline void sincos(const double* q, int count, double* sine, double* cosine) {
  for (int i = 0; i < count; i += 4) {
    const int lanes = count - i < 4 ? count - i : 4;
    Pack x = {}, s, c;
    bool reducible = true;
    for (int l = 0; l < lanes; ++l) {
      x[l] = q[i + l];
      reducible &= magnitude(q[i + l]) <= kLargestReducedAngle;
    }
    sincos(x, s, c);
    for (int l = 0; l < lanes; ++l) sine[i + l] = s[l], cosine[i + l] = c[l];
    if (!reducible)
      for (int l = 0; l < lanes; ++l)
        if (!(magnitude(q[i + l]) <= kLargestReducedAngle))
          sine[i + l] = __builtin_sin(q[i + l]), cosine[i + l] = __builtin_cos(q[i + l]);
  }
}

STILLREACH_END
