// What configurations keep without joints, with every buffer exactly as long as the headers ask for, under the
// sanitizers: facts that hold for any arm, and a row has the same bits alone.
#include "aligned.hpp"
#include "check.hpp"
#include "robot.hpp"

namespace {

struct Case {
  int n, m, sizes, count = 0;
  stillreach::ArmMemory arm;
  std::vector<double> q, rates, scales, whole, joint, worst, every;
  std::vector<std::int32_t> which, sets;
  stillreach::LossBatch b{};

  Case(const Chain& chain, int rows, int most, int configurations)
      : n(chain.n()), m(rows), sizes(most), arm(chain.arm()), rates(n, 1.0), scales(m, 1.0) {
    b.arm = arm.view();
    Random random(static_cast<std::uint64_t>(17 + n));
    q = random.vector(configurations * n, 2.0);
    long of_size = 1;
    for (int s = 0; s < sizes; ++s) count += static_cast<int>(of_size = of_size * (n - s) / (s + 1));
    b.m = m;
    for (int r = 0; r < m; ++r) b.rows[r] = r;
    b.tool_axes = n % 2;
    b.sizes = sizes;
    b.count = count;
    whole.assign(configurations, -7e77);
    joint.assign(configurations * n, -7e77);
    worst.assign(configurations * sizes, -7e77);
    every.assign(configurations * count, -7e77);
    which.assign(configurations * sizes, -7);
    sets.assign(count * sizes, -1);
    std::vector<int> set;
    int at = 0;
    for (int size = 1; size <= sizes; ++size) fill(size, 0, set, at);
    CHECK(at == count);
  }
  void fill(int size, int first, std::vector<int>& set, int& at) {
    if (static_cast<int>(set.size()) == size) {
      for (int s = 0; s < size; ++s) sets[at * sizes + s] = set[s];
      ++at;
      return;
    }
    for (int i = first; i < n; ++i) {
      set.push_back(i);
      fill(size, i + 1, set, at);
      set.pop_back();
    }
  }
  void run(bool speeds, std::ptrdiff_t first, std::ptrdiff_t last) {
    b.q = q.data();
    b.rates = rates.data();
    b.scales = scales.data();
    b.sets = sets.data();
    b.whole = speeds ? whole.data() : nullptr;
    b.joint = joint.data();
    b.worst = worst.data();
    b.which = speeds ? nullptr : which.data();
    b.every = every.data();
    Aligned doubles(kernel().loss_doubles(n, sizes, count));
    (speeds ? kernel().guaranteed_rows : kernel().relative_rows)(b, first, last, doubles.data);
  }
  // Of all rows: the worst is the least of all, a joint's is that of its set, and more losses never leave more.
  void check_rows(bool speeds, int row, int last) {
    for (; row < last; ++row) {
      const double* all = &every[row * count];
      int at = 0, begin = 0;
      for (int s = 0; s < sizes; ++s) {
        double least = kInfinity;
        for (begin = at; at < count && (s + 1 == sizes || sets[at * sizes + s + 1] < 0); ++at)
          least = all[at] < least ? all[at] : least;
        CHECK_NEAR(worst[row * sizes + s], least, speeds ? 1e-12 : 0.0);
        if (!speeds) CHECK(all[begin + which[row * sizes + s]] == least);
        CHECK(least >= 0.0 && (s == 0 || least <= worst[row * sizes + s - 1]));
      }
      double squares = 0.0;
      for (int i = 0; i < n; ++i) {
        CHECK(joint[row * n + i] == all[i]);
        squares += all[i] * all[i];
        if (speeds) CHECK(all[i] <= whole[row]);
      }
      if (!speeds) CHECK_NEAR(squares, n - m, 1e-11);
    }
  }
};

void test_arms_of_all_lengths() {
  for (int n : {6, 7, 8, 9, 11, 13, 14, 30})
    for (int m : {1, 3, 6}) {
      const int sizes = n > 14 ? 2 : n - m < 4 ? n - m + 1 : 4;
      if (sizes > n) continue;
      const int rows = n > 11 ? 5 : 11;
      Case c(skew_chain(n, static_cast<std::uint64_t>(m)), m, sizes, rows);
      for (bool speeds : {false, true}) {
        if (speeds && n > 14 && m > 3) continue;  // more facets than a test has time for
        c.run(speeds, 0, rows);
        c.check_rows(speeds, 0, rows);
        const std::vector<double> before = c.every;
        c.run(speeds, 3, 4);
        for (int f = 0; f < c.count; ++f) CHECK(c.every[3 * c.count + f] == before[3 * c.count + f]);
      }
    }
}

// Unit planar 3R at (any, 60, 120) deg: every joint leaves 1 / sqrt(3), and rates of 1 give sqrt(3) and its half.
void test_an_arm_solved_by_hand() {
  Case c(planar_chain(3), 2, 2, 1);
  c.b.tool_axes = 0;
  c.q = {0.3, std::acos(-1.0) / 3.0, 2.0 * std::acos(-1.0) / 3.0};
  c.run(false, 0, 1);
  for (int i = 0; i < 3; ++i) CHECK_NEAR(c.joint[i], 1.0 / std::sqrt(3.0), 1e-15);
  CHECK(c.worst[1] == 0.0);
  c.run(true, 0, 1);
  CHECK_NEAR(c.whole[0], std::sqrt(3.0), 1e-14);
  for (int i = 0; i < 3; ++i) CHECK_NEAR(c.joint[i], std::sqrt(3.0) / 2.0, 1e-14);
  CHECK(c.worst[1] == 0.0);
  c.q = {0.3, 0.0, 0.0};  // stretched: the rank is 1
  c.run(false, 0, 1);
  CHECK(std::isnan(c.joint[0]) && std::isnan(c.worst[0]) && std::isnan(c.every[0]));
  c.run(true, 0, 1);
  CHECK(c.whole[0] == 0.0);
}

}  // namespace

int main() {
  test_arms_of_all_lengths();
  test_an_arm_solved_by_hand();
  return finish("test_losses");
}
