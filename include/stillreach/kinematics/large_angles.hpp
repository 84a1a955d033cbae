// Sine and cosine of one angle of any size. The angle times 2 / pi is formed in integers, of which only the digits
// count that are neither whole turns nor below rounding (Payne and Hanek, 1983), so that every platform gives the same
// bits.
#pragma once

#include "stillreach/simd/packs.hpp"

STILLREACH_BEGIN

// Sine and cosine on [-pi/4, pi/4]: polynomials that err least (by Remez's exchange; 2e-18 and 5e-20, with these
// coefficients).
template <class P>
STILLREACH_INLINE void sincos_reduced(P r, P& sine, P& cosine) {
  const P z = r * r;
  P s = fill<P>(0x1.5d61cfddebb1ep-33);
  s = madd(s, z, fill<P>(-0x1.ae5da9ea151d7p-26));
  s = madd(s, z, fill<P>(0x1.71de346756cccp-19));
  s = madd(s, z, fill<P>(-0x1.a01a019aa3718p-13));
  s = madd(s, z, fill<P>(0x1.111111110ea87p-7));
  s = madd(s, z, fill<P>(-0x1.555555555553dp-3));
  sine = madd(s * z, r, r);
  P c = fill<P>(-0x1.8fb10a1078b0bp-37);
  c = madd(c, z, fill<P>(0x1.1ee9f11088993p-29));
  c = madd(c, z, fill<P>(-0x1.27e4f81265312p-22));
  c = madd(c, z, fill<P>(0x1.a01a019cbf0d4p-16));
  c = madd(c, z, fill<P>(-0x1.6c16c16c1521dp-10));
  c = madd(c, z, fill<P>(0x1.555555555554cp-5));
  cosine = madd(c * z, z, madd(z, fill<P>(-0.5), fill<P>(1.0)));
}

// An angle as `quadrant` quarters of a turn and a rest within an eighth, of which `more` is what `rest` has no digits
// for.
struct ReducedAngle {
  double rest, more;
  unsigned quadrant;
};

constexpr int kProductWords = 10;  // of 32 bits, the lowest first

// 32 bits of a product, from bit `low` on.
STILLREACH_INLINE unsigned bits_from(const unsigned* product, int low) {
  const int word = low / 32, offset = low % 32;
  return offset == 0 ? product[word] : product[word] >> offset | product[word + 1] << (32 - offset);
}

// mantissa 2^exponent times 2 / pi but for multiples of 4. Returns how many bits of the product are behind the point.
inline int quarters(unsigned long long mantissa, int exponent, unsigned* product) {
  const unsigned two_over_pi[] = {// what is behind the point, 32 bits each
                                  0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab,
                                  0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
                                  0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b,
                                  0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7,
                                  0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1,
                                  0x1f8d5d08, 0x56033046, 0xfc7b6bab, 0xf0cfbc20};
  constexpr int words = 7;  // 138 bits behind the point, where the nearest double to a multiple of pi / 2 has 62 zeros
  const int skipped = exponent > 2 ? (exponent - 2) / 32 : 0;
  for (int w = 0; w < kProductWords; ++w) product[w] = 0;
  for (int half = 0; half < 2; ++half) {
    const unsigned long long factor = half == 0 ? mantissa & 0xffffffff : mantissa >> 32;
    unsigned long long carry = 0;
    for (int w = 0; w < words; ++w) {
      const unsigned long long sum = factor * two_over_pi[skipped + words - 1 - w] + product[w + half] + carry;
      product[w + half] = static_cast<unsigned>(sum);
      carry = sum >> 32;
    }
    product[words + half] = static_cast<unsigned>(carry);
  }
  return 32 * (words + skipped) - exponent;
}

// Of a finite angle from 2^20 on.
inline ReducedAngle reduce_large(double angle) {
  unsigned long long bits;
  STILLREACH_LIBRARY(memcpy)(&bits, &angle, sizeof bits);
  const unsigned long long fraction = 1ULL << 52;
  unsigned product[kProductWords];
  const int point = quarters((bits & (fraction - 1)) | fraction, static_cast<int>(bits >> 52 & 0x7ff) - 1075, product);
  unsigned quadrant = bits_from(product, point), part[4];
  for (int w = 0; w < 4; ++w) part[w] = bits_from(product, point - 32 * (w + 1));
  const bool beyond = (part[0] >> 31) != 0;  // over half a quarter: back from the next one
  if (beyond) {
    ++quadrant;
    for (unsigned& word : part) word = ~word;
  }
  unsigned long long head = static_cast<unsigned long long>(part[0]) << 32 | part[1];
  unsigned long long tail = static_cast<unsigned long long>(part[2]) << 32 | part[3];
  int zeros = 0;
  for (; head >> 63 == 0 && zeros < 64; ++zeros) {
    head = head << 1 | tail >> 63;
    tail <<= 1;
  }
  // times pi / 2, of 21, 21 and 53 bits: the first products are exact
  const double high = static_cast<double>(head >> 32), low = static_cast<double>(head & 0xffffffff) * 0x1p-32;
  const double first = high * 0x1.921fbp+0;
  const double second =
      high * 0x1.5110ap-22 + (low * 0x1.921fbp+0 + (high * 0x1.4611a62633146p-42 + low * 0x1.5110ap-22));
  const double unit = STILLREACH_LIBRARY(ldexp)(beyond ? -1.0 : 1.0, -32 - zeros), rest = first + second;
  return {unit * rest, unit * ((first - rest) + second), quadrant};
}

// Of an angle beyond the reduction of sincos.hpp; of a NaN and of infinity NaN.
inline STILLREACH_NOINLINE void sincos_large(double angle, double& sine, double& cosine) {
  if (!is_finite(angle)) {
    sine = cosine = angle - angle;
    return;
  }
  const ReducedAngle reduced = reduce_large(magnitude(angle));
  double s, c;
  sincos_reduced(reduced.rest, s, c);
  const double own_sine = madd(reduced.more, c, s), own_cosine = madd(-reduced.more, s, c);
  const bool odd = (reduced.quadrant & 1) != 0, down = (reduced.quadrant & 2) != 0,
             left = ((reduced.quadrant + 1) & 2) != 0;
  const double a = odd ? own_cosine : own_sine, b = odd ? own_sine : own_cosine;
  sine = down != (angle < 0.0) ? -a : a;
  cosine = left ? -b : b;
}

STILLREACH_END
