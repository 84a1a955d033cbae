// Pose and Jacobian of a chain: arms solved by hand, derivatives by finite differences, no number written too far.
#include <array>
#include <cmath>

#include "check.hpp"
#include "robot.hpp"

namespace {

struct Kinematics {
  stillreach::ArmMemory memory;
  stillreach::ArmView arm;
  std::vector<double> scratch, jacobian;
  double pose[12];
  explicit Kinematics(const Chain& c)
      : memory(c.arm()), arm(memory.view()), scratch(10 * c.n()), jacobian(6 * c.n() + 1, 1234.5) {}
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;
  void at(const std::vector<double>& q, bool with_jacobian = true) {
    kernel().kinematics(arm, q.data(), scratch.data(), pose, with_jacobian ? jacobian.data() : nullptr);
  }
};

void planar_arm_by_hand() {
  Kinematics k(planar_chain(2));
  const double a = 0.3, b = 1.1;
  k.at({a, b});
  const double x = std::cos(a) + std::cos(a + b), y = std::sin(a) + std::sin(a + b);
  const double pose[12] = {std::cos(a + b), std::sin(a + b), 0, -std::sin(a + b), std::cos(a + b), 0, 0, 0, 1, x, y, 0};
  const double jacobian[12] = {-y, x, 0, 0, 0, 1, -std::sin(a + b), std::cos(a + b), 0, 0, 0, 1};
  for (int i = 0; i < 12; ++i) CHECK_NEAR(k.pose[i], pose[i], 1e-15);
  for (int i = 0; i < 12; ++i) CHECK_NEAR(k.jacobian[i], jacobian[i], 1e-15);
}

void slide_on_a_turn_by_hand() {  // turn about y, then slide along the turned x
  Chain c;
  c.joint(0, 0, 0.5, 0, 1, 0);
  c.joint(0, 0, 0, 1, 0, 0, stillreach::JointKind::PRISMATIC);
  c.shift(1, 0, 0);
  Kinematics k(c);
  const double a = 0.4, d = 0.25, reach = 1.0 + d;
  k.at({a, d});
  CHECK_NEAR(k.pose[9], reach * std::cos(a), 1e-15);
  CHECK_NEAR(k.pose[10], 0.0, 1e-15);
  CHECK_NEAR(k.pose[11], 0.5 - reach * std::sin(a), 1e-15);
  const double jacobian[12] = {-reach * std::sin(a), 0, -reach * std::cos(a), 0, 1, 0,
                               std::cos(a),          0, -std::sin(a),         0, 0, 0};
  for (int i = 0; i < 12; ++i) CHECK_NEAR(k.jacobian[i], jacobian[i], 1e-15);
}

void paper_arm_by_hand() {  // upright: reach 15 ft; all of it laid over by the first pitch: towards -x
  Kinematics k(paper_chain());
  std::vector<double> q(11, 0.0);
  k.at(q);
  CHECK_NEAR(k.pose[11], 15 * 0.3048, 1e-12);
  q[1] = kPi / 2;
  k.at(q);
  CHECK_NEAR(k.pose[9], -5 * 0.762, 1e-12);
  CHECK_NEAR(k.pose[11], 0.762, 1e-12);
}

// A parallelogram: the second joint turns back what the first one turned, and the second link keeps its direction.
void coupled_joints_by_hand() {
  Kinematics k(planar_chain(2));
  const int leader[2] = {0, 0};
  const double factor[2] = {1.0, -1.0}, offset[2] = {0.0, 0.5};
  const stillreach::Coupling coupling{2, leader, factor, offset};
  stillreach::ArmView arm = k.arm;
  arm.n = 1;
  arm.coupling = &coupling;
  const double q = 0.3;
  kernel().kinematics(arm, &q, k.scratch.data(), k.pose, k.jacobian.data());
  CHECK_NEAR(k.pose[0], std::cos(0.5), 1e-15);
  CHECK_NEAR(k.pose[9], std::cos(q) + std::cos(0.5), 1e-15);
  CHECK_NEAR(k.pose[10], std::sin(q) + std::sin(0.5), 1e-15);
  const double column[6] = {-std::sin(q), std::cos(q), 0, 0, 0, 0};
  for (int r = 0; r < 6; ++r) CHECK_NEAR(k.jacobian[r], column[r], 1e-15);
  CHECK(k.jacobian[6] == 1234.5);
}

// Column i of the Jacobian is what a small motion of joint i does to the pose.
void jacobian_is_the_derivative(const Chain& chain, std::uint64_t seed) {
  const int n = chain.n();
  const double h = 1e-6;
  Random random(seed);
  std::vector<double> q = random.vector(n, 3.0);
  Kinematics at(chain), up(chain), down(chain);
  at.at(q);
  for (int i = 0; i < n; ++i) {
    std::vector<double> high = q, low = q;
    high[i] += h;
    low[i] -= h;
    up.at(high, false);
    down.at(low, false);
    double rotation[3][3] = {};  // dR/dq R'
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a)
          rotation[r][c] += (up.pose[3 * a + r] - down.pose[3 * a + r]) / (2 * h) * at.pose[3 * a + c];
    const double* column = at.jacobian.data() + 6 * i;
    const double tolerance = 1e-9 * n;
    for (int r = 0; r < 3; ++r) CHECK_NEAR(column[r], (up.pose[9 + r] - down.pose[9 + r]) / (2 * h), tolerance);
    CHECK_NEAR(column[3], rotation[2][1], tolerance);
    CHECK_NEAR(column[4], rotation[0][2], tolerance);
    CHECK_NEAR(column[5], rotation[1][0], tolerance);
  }
}

// The product of the placements as they were given and of each joint's motion (Rodrigues, 1840), number by number.
using Pose = std::array<double, 16>;
Pose operator*(const Pose& a, const Pose& b) {
  Pose c{};
  for (int r = 0; r < 4; ++r)
    for (int s = 0; s < 4; ++s)
      for (int k = 0; k < 4; ++k) c[4 * r + s] += a[4 * r + k] * b[4 * k + s];
  return c;
}
Pose turned(double x, double y, double z, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), v = 1 - c;
  return {x * x * v + c,
          x * y * v - z * s,
          x * z * v + y * s,
          0,
          y * x * v + z * s,
          y * y * v + c,
          y * z * v - x * s,
          0,
          z * x * v - y * s,
          z * y * v + x * s,
          z * z * v + c,
          0,
          0,
          0,
          0,
          1};
}
Pose shifted(double x, double y, double z) { return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1}; }

// Axes of neighbours at angles that a way from one to the next could stumble over: none, all but none, a right one, a
// half turn.
Pose any_way(Random& random) {
  const double tilts[] = {0.0, 1e-17, 3e-16, 1e-15, 1e-9, 1e-3, 1.0, kPi / 2, kPi - 1e-9, kPi - 1e-15, kPi};
  const double turns[] = {0.0, 1e-16, 0.3, kPi / 2, kPi, -kPi / 2, 4.0};
  const double first = turns[random.below(7)], tilt = tilts[random.below(11)], last = turns[random.below(7)];
  const double x = random.between(-1, 1), y = random.below(2), z = random.between(-1, 1);
  return shifted(x, y, z) * turned(0, 0, 1, first) * turned(1, 0, 0, tilt) * turned(0, 0, 1, last);
}

void poses_and_jacobians_are_products() {
  Random random(8);
  for (int sample = 0; sample < 4000; ++sample) {
    const int n = 1 + random.below(8);
    const double tolerance = 1e-14 * n;
    Chain chain;
    Pose expected = shifted(0, 0, 0);
    std::vector<std::array<double, 3>> axis, at;
    const std::vector<double> q = random.vector(n, 3.0);
    for (int i = 0; i <= n; ++i) {
      const Pose way = any_way(random);
      chain.placements.insert(chain.placements.end(), way.begin(), way.end());
      expected = expected * way;
      if (i == n) break;
      double a[3] = {0, 0, random.below(2) ? 1.0 : -1.0};
      if (random.below(3) == 0) {
        a[random.below(2)] = a[2];
        a[2] = 0.0;
      }
      const bool turns = random.below(4) != 0;
      chain.axes.insert(chain.axes.end(), a, a + 3);
      chain.kinds.push_back(turns ? stillreach::JointKind::REVOLUTE : stillreach::JointKind::PRISMATIC);
      const Pose& e = expected;
      axis.push_back({});
      for (int r = 0; r < 3; ++r) axis[i][r] = e[4 * r] * a[0] + e[4 * r + 1] * a[1] + e[4 * r + 2] * a[2];
      at.push_back({e[3], e[7], e[11]});
      expected = expected * (turns ? turned(a[0], a[1], a[2], q[i]) : shifted(a[0] * q[i], a[1] * q[i], a[2] * q[i]));
    }
    Kinematics k(chain);
    k.at(q);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) CHECK_NEAR(k.pose[3 * c + r], expected[4 * r + c], tolerance);
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < 3; ++r) {
        const int s = (r + 1) % 3, t = (r + 2) % 3;
        const bool turns = chain.kinds[i] == stillreach::JointKind::REVOLUTE;
        const double across =
            axis[i][s] * (expected[4 * t + 3] - at[i][t]) - axis[i][t] * (expected[4 * s + 3] - at[i][s]);
        CHECK_NEAR(k.jacobian[6 * i + r], turns ? across : axis[i][r], 10 * tolerance);
        CHECK_NEAR(k.jacobian[6 * i + 3 + r], turns ? axis[i][r] : 0.0, tolerance);
      }
  }
}

void sines_are_close() {  // of one joint about z they are the pose; long doubles know them better
  Random random(9);
  for (double range : {0.8, 4.0, 1e3, 7.9e5, 1e7})
    for (int sample = 0; sample < 20000; ++sample) {
      const double q = random.between(-range, range);
      static Kinematics k(planar_chain(1));
      k.at({q}, false);
      CHECK_NEAR(k.pose[0], static_cast<double>(std::cos(static_cast<long double>(q))), 3e-16);
      CHECK_NEAR(k.pose[1], static_cast<double>(std::sin(static_cast<long double>(q))), 3e-16);
    }
}

void large_angles() {  // whole turns change nothing, also where the fast sine hands over to the C library
  for (double turns : {1.0, -7.0, 1e4, 2e5, 1e9}) {
    const double a = 0.7 + 2 * kPi * turns, b = -1.9 - 2 * kPi * turns;
    Kinematics k(planar_chain(2));
    k.at({a, b});
    CHECK_NEAR(k.pose[9], std::cos(a) + std::cos(a) * std::cos(b) - std::sin(a) * std::sin(b), 1e-14);
    CHECK_NEAR(k.pose[10], std::sin(a) + std::sin(a) * std::cos(b) + std::cos(a) * std::sin(b), 1e-14);
  }
}

void writes_no_further_than_it_says() {
  for (int n = 1; n <= 13; ++n) {
    const Chain chain = snake_chain(n);
    Kinematics k(chain);
    k.jacobian.assign(6 * n + 10, 1234.5);
    k.scratch.assign(10 * n + 8, 1234.5);
    k.at(Random(n).vector(n, 2.0));
    for (int i = 6 * n; i < 6 * n + 10; ++i) CHECK(k.jacobian[i] == 1234.5);
    for (int i = 10 * n; i < 10 * n + 8; ++i) CHECK(k.scratch[i] == 1234.5);
  }
}

void with_and_without_jacobian_agree() {
  const Chain chain = skew_chain(9, 4);
  Kinematics with(chain), without(chain);
  const std::vector<double> q = Random(5).vector(9, 2.0);
  with.at(q);
  without.at(q, false);
  for (int i = 0; i < 12; ++i) CHECK(with.pose[i] == without.pose[i]);
}

}  // namespace

int main() {
  planar_arm_by_hand();
  slide_on_a_turn_by_hand();
  coupled_joints_by_hand();
  paper_arm_by_hand();
  for (int n : {1, 2, 3, 4, 5, 6, 7, 8, 11}) {
    jacobian_is_the_derivative(snake_chain(n), n);
    jacobian_is_the_derivative(skew_chain(n, 100 + n), n);
  }
  jacobian_is_the_derivative(paper_chain(), 3);
  jacobian_is_the_derivative(snake_chain(500), 4);
  poses_and_jacobians_are_products();
  sines_are_close();
  large_angles();
  writes_no_further_than_it_says();
  with_and_without_jacobian_agree();
  return finish("kinematics");
}
