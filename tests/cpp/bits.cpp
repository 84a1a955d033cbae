// Prints a checksum of what the kernel computes, law by law: two compilers or processors with the same arithmetic print
// the same. See tests/unit/test_compilers.py.
#include <cstdio>

#include "robot.hpp"

namespace {

// Fowler, Noll and Vo (1991), 64 bits.
struct Checksum {
  std::uint64_t value = 14695981039346656037u;
  void add(const void* data, std::size_t size) {
    const unsigned char* byte = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value = (value ^ byte[i]) * 1099511628211u;
  }
  template <class All>
  void add(const All& all) {
    add(all.data(), all.size() * sizeof *all.data());
  }
};

// A walk with faults on the way, from another pose every 40th tick; in its second half on a target.
void ticks(Checksum& sum, const Chain& chain, const stillreach::LawSettings& law, const Options& o) {
  Robot robot(chain, law, o);
  Random random(7);
  std::vector<double> q, twist;
  const double target[12] = {1, 0, 0, 0, 0, -1, 0, 1, 0, 0.4, -0.3, 0.5};
  for (int t = 0; t < 400; ++t) {
    if (t % 40 == 0) {
      q = random.vector(robot.n, t % 80 ? 2.0 : 1e-9);
      twist = random.vector(6, t % 120 ? 1.0 : 0.05);
    }
    if (t % 50 == 25) robot.fail(random.below(robot.n));
    if (t % 50 == 40) robot.restore(random.below(robot.n));
    robot.tick(q.data(), twist.data(), t < 200 ? nullptr : target);
    sum.add(robot.rates);
    sum.add(robot.residual);
    sum.add(robot.active);
    sum.add(robot.jacobian);
    sum.add(&robot.answer.damping, sizeof(double));
    sum.add(&robot.answer.status, sizeof robot.answer.status);
    for (int i = 0; i < robot.n; ++i) q[i] += 0.01 * robot.rates[i];
  }
}

// 203 rows, on and beside singularities, with two joints that failed.
void rows(Checksum& sum, const Chain& chain, const stillreach::LawSettings& law, int m) {
  const int count = 203;
  const Robot robot(chain, law);
  const int n = robot.n;
  Random random(17);
  std::vector<double> q = random.vector(count * n, 2.0), twist = random.vector(count * 6, 0.6), lower(n, -0.5),
                      upper(n, 0.6);
  for (int i = 0; i < count * n; ++i)
    if (i / n % 9 == 0) q[i] = i % 2 ? 0.0 : 1e-7;
  lower[1] = upper[1] = 0.0;
  lower[n - 1] = upper[n - 1] = 0.1;
  std::vector<double> rates(count * n), residual(count * m), damping(count);
  std::vector<std::int32_t> status(count);
  stillreach::Batch b{};
  b.arm = robot.arm.view();
  b.law = law;
  b.m = m;
  b.every_row = m == 6;
  for (int r = 0; r < m; ++r) b.rows[r] = r;
  b.q = q.data();
  b.twist = twist.data();
  b.twist_stride = 6;
  b.lower = lower.data();
  b.upper = upper.data();
  b.rates = rates.data();
  b.residual = residual.data();
  b.damping = damping.data();
  b.status = status.data();
  std::vector<double> doubles(kernel().batch_doubles(n, false) + 8);
  std::vector<int> ints(kernel().batch_ints(n));
  std::vector<std::int8_t> bytes(kernel().batch_bytes(n));
  const std::size_t off = reinterpret_cast<std::uintptr_t>(doubles.data()) % 64 / sizeof(double);
  kernel().batch(b, 0, count, {doubles.data() + (off ? 8 - off : 0), ints.data(), bytes.data()});
  sum.add(rates);
  sum.add(residual);
  sum.add(damping);
  sum.add(status);
}

}  // namespace

int main() {
  Options narrow, limits, weighted;
  narrow.rate = 0.3;
  narrow.transition_rate = 2.0;
  limits.rows = {0, 1, 2};
  limits.position = 1.5;
  limits.acceleration = 20.0;
  limits.null_kind = stillreach::NullMotionKind::MANIPULABILITY;
  weighted.joint_matrix = true;
  weighted.rate = 0.5;
  weighted.rows = {0, 2, 4, 5};
  weighted.tool_axes = true;
  for (const NamedLaw& law : every_law()) {
    Checksum one, many;
    ticks(one, paper_chain(), law.settings, narrow);
    ticks(one, skew_chain(9, 3), law.settings, limits);
    ticks(one, snake_chain(14), law.settings, weighted);
    ticks(one, skew_chain(3, 5), law.settings, {});
    for (int m : {3, 6}) {
      rows(many, paper_chain(), law.settings, m);
      rows(many, skew_chain(7, 7), law.settings, m);
    }
    std::printf("%s: ticks %016llx, batch %016llx\n", law.name, static_cast<unsigned long long>(one.value),
                static_cast<unsigned long long>(many.value));
  }
}
