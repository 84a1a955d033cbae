// Inverse kinematics with every buffer exactly as long as the headers ask for, under the sanitizers: what is found is
// right and inside the limits, and a row has the same bits alone.
#include "aligned.hpp"
#include "check.hpp"
#include "robot.hpp"

namespace {

using stillreach::Hold;
using stillreach::Inverse;

struct Search {
  int n, count, solutions;
  stillreach::ArmMemory arm;
  std::vector<double> target, start, lower, upper, low_start, range, step, values, q, residual;
  std::vector<std::int8_t> turns;
  std::vector<Hold> hold;
  std::vector<std::int32_t> starts, found, used, taken;
  Inverse v{};

  Search(const Chain& chain, int rows, bool limits, int ways, std::uint64_t seed)
      : n(chain.n()), count(rows), solutions(ways), arm(chain.arm()) {
    v.batch.arm = arm.view();
    v.batch.law = law_settings(stillreach::LawKind::LEAST_ERROR);
    v.batch.m = 6;
    for (int r = 0; r < 6; ++r) v.batch.rows[r] = r;
    v.batch.every_row = 1;
    Random random(seed);
    start = random.vector(count * n, 2.0);
    std::vector<double> scratch(10 * n), jacobian(6 * n);
    target.resize(12 * count);
    for (int row = 0; row < count; ++row) {
      const std::vector<double> at = random.vector(n, 2.0);
      kernel().kinematics(v.batch.arm, at.data(), scratch.data(), &target[12 * row], jacobian.data());
    }
    lower.assign(n, limits ? -2.0 : -kInfinity);
    upper.assign(n, limits ? 2.0 : kInfinity);
    low_start.assign(n, -2.0);
    range.assign(n, 4.0);
    step.assign(n, 0.6);
    turns.assign(n, !limits);
    hold.assign(n, Hold::FREE);
    values.assign(n, 0.0);
    starts.assign(count, 20);
    q.assign(count * solutions * n, -7e77);
    residual.assign(count * solutions, -7e77);
    found.assign(count, -1);
    used = taken = found;
  }
  void run(std::ptrdiff_t first, std::ptrdiff_t last) {
    v.target = target.data();
    v.start = start.data();
    v.start_stride = n;
    v.lower = lower.data();
    v.upper = upper.data();
    v.low_start = low_start.data();
    v.range = range.data();
    v.step = step.data();
    v.turns = turns.data();
    v.hold = hold.data();
    v.values = values.data();
    v.choices = 1;
    v.starts = starts.data();
    v.steps = 40;
    v.solutions = solutions;
    v.apart = 1e-3;
    v.tolerance = 1e-9;
    v.stop = [](void*) { return false; };
    v.q = q.data();
    v.residual = residual.data();
    v.found = found.data();
    v.used = used.data();
    v.taken = taken.data();
    Aligned doubles(kernel().batch_doubles(n, false)), more(kernel().inverse_doubles(n));
    std::vector<int> ints(kernel().batch_ints(n), 123456789);
    std::vector<std::int8_t> bytes(kernel().batch_bytes(n), 77);
    kernel().inverse_rows(v, first, last, {doubles.data, ints.data(), bytes.data()}, more.data);
  }
};

void check_answers(Search& s, int least) {
  s.run(0, s.count);
  std::vector<double> scratch(10 * s.n), jacobian(6 * s.n), pose(12);
  int reached = 0;
  for (int row = 0; row < s.count; ++row) {
    CHECK(s.used[row] >= 1 && s.used[row] <= 20 && s.taken[row] >= s.used[row]);
    reached += s.found[row] > 0;
    for (int k = 0; k < s.found[row]; ++k) {
      const double* at = &s.q[(row * s.solutions + k) * s.n];
      for (int i = 0; i < s.n; ++i) {
        CHECK(at[i] >= s.lower[i] && at[i] <= s.upper[i]);
        if (s.hold[i] != Hold::FREE) CHECK(at[i] == s.start[row * s.n + i]);
      }
      kernel().kinematics(s.v.batch.arm, at, scratch.data(), pose.data(), jacobian.data());
      for (int r = 0; r < 12; ++r) CHECK_NEAR(pose[r], s.target[12 * row + r], 3e-9);
    }
  }
  CHECK(reached >= least);
}

void test_random_arms() {
  Random random(11);
  for (int n : {6, 7, 9, 13, 30})
    for (int kind = 0; kind < 4; ++kind) {
      Chain chain;
      for (int i = 0; i < n; ++i) chain.joint(0.0, 0.05 * (i % 2), 0.3, i % 3 == 1, i % 3 == 2, i % 3 == 0);
      chain.shift(0.0, 0.0, 0.1);
      Search s(chain, 70, kind < 2, kind == 1 ? 3 : 1, static_cast<std::uint64_t>(random.below(1000)));
      s.v.nearest = kind == 3;
      if (kind == 2) s.hold[n / 2] = Hold::AT_START;
      check_answers(s, kind == 2 && n < 8 ? 0 : 60);
      const std::vector<double> q = s.q;
      const std::vector<std::int32_t> taken = s.taken;
      for (int row : {0, 3, 69}) {
        s.run(row, row + 1);
        CHECK(s.taken[row] == taken[row]);
        for (int i = 0; i < s.solutions * n; ++i) CHECK(s.q[row * s.solutions * n + i] == q[row * s.solutions * n + i]);
      }
    }
}

// What cannot be reached ends after all starts with the closest configuration: the stretched planar arm.
void test_out_of_reach() {
  Search s(planar_chain(3), 5, false, 1, 3);
  for (int row = 0; row < 5; ++row) {
    double* T = &s.target[12 * row];
    for (int i = 0; i < 9; ++i) T[i] = i % 4 == 0;
    T[9] = 4.0 + row;
    T[10] = T[11] = 0.0;
  }
  s.run(0, 5);
  for (int row = 0; row < 5; ++row) {
    CHECK(s.found[row] == 0 && s.used[row] == 20);
    CHECK_NEAR(s.residual[row], 1.0 + row, 1e-2);
  }
}

}  // namespace

int main() {
  test_random_arms();
  test_out_of_reach();
  return finish("test_inverse");
}
