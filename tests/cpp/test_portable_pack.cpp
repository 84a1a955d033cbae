// Packs as plain structs give the same numbers to the last bit as the compiler's vectors: in every law, tick after
// tick. CUDA compiles those structs; here they run.
#include <cstring>

#include "check.hpp"
#include "portable_kernel.hpp"
#include "robot.hpp"

namespace {

// With multiply-adds where the kernel of this machine has them.
const stillreach::Kernel& plain() {
#if defined(__x86_64__)
  if (std::strcmp(kernel().instruction_set, "baseline") != 0) return portable_kernel_fma();
#endif
  return portable_kernel();
}

template <class T>
bool same(const T* a, const T* b, std::size_t count) {
  return std::memcmp(a, b, count * sizeof(T)) == 0;
}

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return same(a.data(), b.data(), a.size());
}

template <class T>
bool same(stillreach::Span<T> a, stillreach::Span<T> b) {
  return same(a.data(), b.data(), a.size());
}

bool same_answer(const stillreach::Answer& a, const stillreach::Answer& b) {
  return a.status == b.status && a.iterations == b.iterations && same(&a.damping, &b.damping, 1) &&
         same(&a.scale, &b.scale, 1) && same(&a.task_error, &b.task_error, 1);
}

bool same_tick(const Robot& a, const Robot& b) {
  return same_answer(a.answer, b.answer) && same(a.rates, b.rates) && same(a.residual, b.residual) &&
         same(a.active, b.active) && same(a.state.now.pose, b.state.now.pose, 12) && same(a.jacobian, b.jacobian) &&
         same(a.lower, b.lower) && same(a.upper, b.upper) && same(a.reference, b.reference);
}

// A walk with faults on the way, closed loop on a target in its second half; every 40th tick from another pose.
long differences(const Chain& chain, const NamedLaw& law, const Options& o, int ticks) {
  Robot vector(chain, law.settings, o), scalar(chain, law.settings, o);
  Random random(7);
  std::vector<double> q, twist;
  double target[12] = {1, 0, 0, 0, 0, -1, 0, 1, 0, 0.4, -0.3, 0.5};
  long count = 0;
  for (int t = 0; t < ticks; ++t) {
    if (t % 40 == 0) {
      q = random.vector(vector.n, t % 80 ? 2.0 : 1e-9);
      twist = random.vector(6, t % 120 ? 1.0 : 0.05);
    }
    if (t % 50 == 25) {
      const int joint = random.below(vector.n);
      const stillreach::Fault fault{static_cast<stillreach::Health>(random.below(6)), {0.1, 0.2}};
      kernel().set_fault(vector.state, joint, fault);
      plain().set_fault(scalar.state, joint, fault);
    }
    const double* aim = t >= ticks / 2 ? target : nullptr;
    kernel().tick(vector.state, q.data(), twist.data(), aim, vector.core.workspace.view(), vector.answer);
    plain().tick(scalar.state, q.data(), twist.data(), aim, scalar.core.workspace.view(), scalar.answer);
    count += !same_tick(vector, scalar);
    for (int i = 0; i < vector.n; ++i) q[i] += 0.01 * vector.rates[i];
  }
  return count;
}

void check_ticks(const char* arm, const Chain& chain, const Options& o) {
  for (const NamedLaw& law : every_law()) {
    const long count = differences(chain, law, o, 400);
    if (count) std::fprintf(stderr, "%s, law '%s': %ld ticks differ\n", arm, law.name, count);
    CHECK(count == 0);
  }
}

void test_ticks_of_every_law_and_kind_of_task() {
  Options narrow, limits, weighted;
  narrow.rate = 0.3;
  narrow.transition_rate = 2.0;
  check_ticks("paper", paper_chain(), narrow);
  limits.rows = {0, 1, 2};
  limits.position = 1.5;
  limits.acceleration = 20.0;
  limits.null_kind = stillreach::NullMotionKind::MANIPULABILITY;
  check_ticks("skew, position", skew_chain(9, 3), limits);
  weighted.joint_matrix = true;
  weighted.rate = 0.5;
  weighted.rows = {0, 2, 4, 5};
  weighted.tool_axes = true;
  check_ticks("snake, full joint weight", snake_chain(14), weighted);
  check_ticks("short", skew_chain(3, 5), {});
}

// Ranks from 0 to m, columns from fewer than rows to more.
void test_laws_on_jacobians_of_any_rank() {
  Random random(11);
  for (int round = 0; round < 600; ++round) {
    const int m = 1 + random.below(6), n = 1 + random.below(12), rank = random.below(m + 1);
    std::vector<double> jacobian = random.vector(m * n, 1.0), twist = random.vector(m, 2.0), lower(n, -0.7),
                        upper(n, 0.7);
    for (int i = 0; i < n; ++i)
      for (int r = rank; r < m; ++r) jacobian[i * m + r] = rank ? jacobian[i * m + r % rank] * (r + 0.5) : 0.0;
    upper[random.below(n)] = -0.7;
    const stillreach::Problem p{m, n, jacobian.data(), twist.data(), lower.data(), upper.data(), nullptr, {}};
    for (const NamedLaw& law : every_law()) {
      std::vector<double> rates[2], residual[2];
      std::vector<std::int8_t> active[2];
      stillreach::Answer answer[2] = {};
      for (int k = 0; k < 2; ++k) {
        rates[k].resize(n), residual[k].resize(m), active[k].resize(n);
        answer[k].rates = rates[k].data();
        answer[k].residual = residual[k].data();
        answer[k].active = active[k].data();
        Scratch scratch(n, false);
        (k ? plain() : kernel()).solve(law.settings, p, scratch.view(), answer[k]);
      }
      CHECK(same_answer(answer[0], answer[1]) && same(rates[0], rates[1]) && same(residual[0], residual[1]) &&
            same(active[0], active[1]));
    }
  }
}

// Large angles go to the C library, single ones and in packs.
void test_kinematics_at_any_angle() {
  Random random(13);
  for (int n = 1; n <= 9; ++n) {
    const Robot robot(skew_chain(n, n), every_law()[0].settings);
    for (double size : {1e-300, 1e-3, 3.0, 1e5, 1e7}) {
      const std::vector<double> q = random.vector(n, size);
      std::vector<double> scratch(10 * n), pose[2], jacobian[2];
      for (int k = 0; k < 2; ++k) {
        pose[k].resize(12), jacobian[k].resize(6 * n);
        (k ? plain() : kernel())
            .kinematics(robot.arm.view(), q.data(), scratch.data(), pose[k].data(), jacobian[k].data());
      }
      CHECK(same(pose[0], pose[1]) && same(jacobian[0].data(), jacobian[1].data(), 6 * n));
    }
  }
}

struct Rates {
  std::vector<double> rates, residual, damping;
  std::vector<std::int32_t> status;
};

Rates solve_batch(const stillreach::Kernel& k, stillreach::Batch b, int count) {
  const int n = b.arm.n;
  Rates to{std::vector<double>(count * n), std::vector<double>(count * b.m), std::vector<double>(count),
           std::vector<std::int32_t>(count)};
  b.rates = to.rates.data();
  b.residual = to.residual.data();
  b.damping = to.damping.data();
  b.status = to.status.data();
  std::vector<double> doubles(k.batch_doubles(n, false) + 8);
  std::vector<int> ints(k.batch_ints(n));
  std::vector<std::int8_t> bytes(k.batch_bytes(n));
  const std::size_t off = reinterpret_cast<std::uintptr_t>(doubles.data()) % 64 / sizeof(double);
  k.batch(b, 0, count, {doubles.data() + (off ? 8 - off : 0), ints.data(), bytes.data()});
  return to;
}

// Four rows in the lanes, on and beside singularities, with two joints that failed.
void test_batches_of_every_law() {
  const int count = 203;
  Random random(17);
  Robot robot(paper_chain(), every_law()[0].settings);
  std::vector<double> q = random.vector(count * robot.n, 2.0), twist = random.vector(count * 6, 0.6),
                      lower(robot.n, -0.5), upper(robot.n, 0.6);
  for (int i = 0; i < count * robot.n; ++i)
    if (i / robot.n % 9 == 0) q[i] = i % 2 ? 0.0 : 1e-7;
  lower[2] = upper[2] = 0.0;
  lower[7] = upper[7] = 0.1;
  for (const NamedLaw& law : every_law())
    for (int m : {3, 6}) {
      stillreach::Batch b{};
      b.arm = robot.arm.view();
      b.law = law.settings;
      b.m = m;
      b.every_row = m == 6;
      for (int r = 0; r < m; ++r) b.rows[r] = r;
      b.q = q.data();
      b.twist = twist.data();
      b.twist_stride = 6;
      b.lower = lower.data();
      b.upper = upper.data();
      const Rates vector = solve_batch(kernel(), b, count), scalar = solve_batch(plain(), b, count);
      CHECK(same(vector.rates, scalar.rates) && same(vector.residual, scalar.residual));
      CHECK(same(vector.damping, scalar.damping) && same(vector.status, scalar.status));
    }
}

void test_the_kernels_are_two() {
  CHECK(std::strstr(plain().instruction_set, "portable") && !std::strstr(kernel().instruction_set, "portable"));
}

}  // namespace

int main() {
  test_the_kernels_are_two();
  test_ticks_of_every_law_and_kind_of_task();
  test_laws_on_jacobians_of_any_rank();
  test_kinematics_at_any_angle();
  test_batches_of_every_law();
  return finish("test_portable_pack");
}
