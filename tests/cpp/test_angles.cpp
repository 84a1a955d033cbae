// Sines, cosines and arctangents of our own against the C library's long double: any size, hard cases, numbers that are
// none.
#include <cmath>
#include <cstring>
#include <limits>

#include "check.hpp"
#include "robot.hpp"
#include "stillreach/kinematics/arctangent.hpp"
#include "stillreach/kinematics/large_angles.hpp"

namespace {

// How far `value` is from `exact`, in units of its last place.
double places_off(double value, long double exact) {
  int exponent = 0;
  (void)std::frexp(static_cast<double>(exact), &exponent);
  return static_cast<double>(std::fabs(static_cast<long double>(value) - exact) / std::ldexp(1.0L, exponent - 53));
}

// A double of any size from 2^low to 2^high.
double any_size(Random& random, int low, int high) {
  const double size = std::ldexp(random.between(1.0, 2.0), low + random.below(high - low));
  return random.below(2) != 0 ? size : -size;
}

// Sine and cosine as the kernel that runs here computes them: the first axis of an arm of one joint.
struct OneJoint {
  stillreach::ArmMemory arm = planar_chain(1).arm();
  double cosine = 0.0, sine = 0.0;
  void turn(double angle) {
    double scratch[10], pose[12];
    kernel().kinematics(arm.view(), &angle, scratch, pose, nullptr);
    cosine = pose[0];
    sine = pose[1];
  }
};

void sines_of_any_size() {
  Random random(5);
  OneJoint joint;
  double worst = 0.0;
  for (int t = 0; t < 200000; ++t) {
    const double angle = any_size(random, 20, 1024);
    joint.turn(angle);
    worst = std::fmax(worst, places_off(joint.sine, sinl(angle)));
    worst = std::fmax(worst, places_off(joint.cosine, cosl(angle)));
  }
  CHECK(worst < 1.7);
  for (int t = 0; t < 200000; ++t) {
    const double angle = any_size(random, -1074, 20);
    joint.turn(angle);
    CHECK(std::fabs(joint.sine - sinl(angle)) < 3e-16L && std::fabs(joint.cosine - cosl(angle)) < 3e-16L);
  }
}

void hard_angles() {
  OneJoint joint;
  joint.turn(
      0x1.6ac5b262ca1ffp+849);  // of all doubles the nearest to a multiple of pi/2 (Muller, Elementary Functions)
  CHECK(joint.sine == 1.0);
  CHECK(places_off(joint.cosine, -4.68716592425462761112e-19L) < 1.0);
  const double largest = std::numeric_limits<double>::max(), first = std::nextafter(8.0e5, 9.0e5);
  for (const double angle : {first, 0x1p20, 0x1p52, 0x1p53, 0x1p63, 0x1p64, 1e22, 0x1p120, 0x1p1023, largest})
    for (const double side : {1.0, -1.0}) {
      joint.turn(side * angle);
      CHECK(places_off(joint.sine, sinl(side * angle)) < 1.7 && places_off(joint.cosine, cosl(side * angle)) < 1.7);
    }
  for (const double none : {kInfinity, -kInfinity, std::nan("")}) {
    joint.turn(none);
    CHECK(std::isnan(joint.sine) && std::isnan(joint.cosine));
  }
}

void lanes_turn_as_one_joint_does() {
  Random random(7);
  OneJoint joint;
  constexpr int rows = 24;
  std::vector<double> q(rows), poses(16 * rows), doubles(kernel().kinematics_doubles(1, 0, false) + 8);
  for (int row = 0; row < rows; ++row) q[row] = row % 3 == 0 ? random.between(-3, 3) : any_size(random, 0, 1024);
  double* aligned = doubles.data();
  while (reinterpret_cast<std::uintptr_t>(aligned) % 64 != 0) ++aligned;
  stillreach::KinematicsBatch batch{};
  batch.arm = joint.arm.view();
  batch.q = q.data();
  batch.pose = poses.data();
  kernel().kinematics_rows(batch, 0, rows, aligned);
  for (int row = 0; row < rows; ++row) {
    joint.turn(q[row]);
    CHECK(poses[16 * row] == joint.cosine && poses[16 * row + 4] == joint.sine);
  }
}

void arctangents() {
  using stillreach::first_quadrant_angle;
  Random random(6);
  double worst = 0.0;
  for (int t = 0; t < 400000; ++t) {
    const double scale = any_size(random, -500, 500), y = std::fabs(scale),
                 x = std::fabs(scale * any_size(random, -60, 60));
    const double half = random.between(0.0, kPi / 2);
    worst = std::fmax(worst, places_off(first_quadrant_angle(y, x), atan2l(y, x)));
    worst = std::fmax(worst, places_off(first_quadrant_angle(std::sin(half), std::cos(half)),
                                        atan2l(std::sin(half), std::cos(half))));
  }
  CHECK(worst < 1.7);
  CHECK(first_quadrant_angle(0.0, 3.0) == 0.0);
  CHECK(first_quadrant_angle(2.0, 0.0) == kPi / 2);
  CHECK(first_quadrant_angle(0.7, 0.7) == kPi / 4);
  CHECK(first_quadrant_angle(1e-310, 1.0) == 1e-310);
  CHECK(first_quadrant_angle(kInfinity, 1.0) == kPi / 2);
  CHECK(std::isnan(first_quadrant_angle(std::nan(""), 1.0)) && std::isnan(first_quadrant_angle(1.0, std::nan(""))));
}

}  // namespace

int main() {
  sines_of_any_size();
  hard_angles();
  lanes_turn_as_one_joint_does();
  arctangents();
  return finish("test_angles");
}
