// Batches with every buffer exactly as long as the headers ask for, under the sanitizers; each row has the bits that
// the single tick's functions give for it.
#include "aligned.hpp"
#include "check.hpp"
#include "robot.hpp"

namespace {

using stillreach::Batch;

struct BatchScratch {
  Aligned doubles;
  std::vector<int> ints;
  std::vector<std::int8_t> bytes;
  BatchScratch(int n, bool full)
      : doubles(kernel().batch_doubles(n, full)),
        ints(kernel().batch_ints(n), 123456789),
        bytes(kernel().batch_bytes(n), 77) {}
  stillreach::Memory memory() { return {doubles.data, ints.data(), bytes.data()}; }
};

struct Setting {
  std::vector<int> rows = {0, 1, 2, 3, 4, 5};
  bool tool_axes = false, joint_matrix = false, units = false, reference = false, per_row = true, limits = false,
       jacobians = false;
};

// Rows with places, twists and faults of every kind, and arrays for all answers.
struct Rows {
  int n, m, count;
  stillreach::ArmMemory arm;
  std::vector<double> q, jacobians, twist, lower, upper, reference, last, position_lower, position_upper, acceleration;
  std::vector<double> units, weight, task_weight;
  std::vector<std::int8_t> active;
  std::vector<double> rates, residual, damping, scale, task_error, pose, jacobian;
  std::vector<std::int32_t> status, iterations;
  Batch b{};

  Rows(const Chain& chain, const stillreach::LawSettings& law, const Setting& s, int rows, std::uint64_t seed)
      : n(chain.n()), m(static_cast<int>(s.rows.size())), count(rows), arm(chain.arm()) {
    b.arm.n = n;
    if (!s.jacobians) b.arm = arm.view();
    Random random(seed);
    q = random.vector(count * n, 3.0);
    twist = random.vector(count * (s.jacobians ? m : 6), 0.5);
    const int bounds = s.per_row ? count : 1;
    lower.assign(bounds * n, -0.4);
    upper.assign(bounds * n, 0.6);
    for (int row = 0; row < count; ++row) {
      if (random.below(4) == 0)
        for (int i = 0; i < n; ++i) q[row * n + i] = random.below(2) ? 0.0 : 1e-6;
      if (random.below(8) == 0) twist[row * (s.jacobians ? m : 6)] = kInfinity * random.between(-1, 1);
    }
    for (int row = 0; row < bounds; ++row)
      for (int failed = random.below(n + 1); failed > 0; --failed) {
        const int i = row * n + random.below(n);
        lower[i] = upper[i] = random.below(3) ? 0.0 : 0.1;
      }
    if (s.per_row && random.below(2)) upper[random.below(count * n)] = -1.0;  // leaves no rate
    tell(law, s, random);
  }
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;

  void tell(const stillreach::LawSettings& law, const Setting& s, Random& random) {
    b.law = law;
    b.m = m;
    b.tool_axes = s.tool_axes;
    b.every_row = m == 6 && !s.tool_axes;
    for (int r = 0; r < m; ++r) b.rows[r] = s.rows[r];
    if (s.units || s.joint_matrix) {
      units.assign(n, 0.7);
      b.metric.units = b.metric.columns = units.data();
    }
    if (s.joint_matrix) {
      weight = coupling_matrix(n);
      b.metric.joints = weight.data();
    }
    if (s.jacobians) {
      jacobians = random.vector(count * m * n, 1.0);
      b.jacobians = jacobians.data();
    } else
      b.q = q.data();
    b.twist = twist.data();
    b.twist_stride = s.jacobians ? m : 6;
    b.lower = lower.data();
    b.upper = upper.data();
    b.bounds_stride = s.per_row ? n : 0;
    if (s.reference) {
      reference = random.vector(count * n, 0.3);
      b.reference = reference.data();
      b.reference_stride = n;
    }
    if (s.limits) {
      last = random.vector(count * n, 0.3);
      position_lower.assign(n, -2.0);
      position_upper.assign(n, 2.5);
      acceleration.assign(n, 3.0);
      b.last = last.data();
      b.position_lower = position_lower.data();
      b.position_upper = position_upper.data();
      b.acceleration = acceleration.data();
      b.period = 0.01;
    }
    rates.assign(count * n, 7.0);
    residual.assign(count * m, 7.0);
    pose.assign(16 * count, 7.0);
    jacobian.assign(count * m * n, 7.0);
    for (std::vector<double>* v : {&damping, &scale, &task_error}) v->assign(count, 7.0);
    status.assign(count, 7);
    iterations.assign(count, 7);
    active.assign(count * n, 7);
    b.rates = rates.data();
    b.status = status.data();
    b.residual = residual.data();
    b.damping = damping.data();
    b.scale = scale.data();
    b.task_error = task_error.data();
    b.active = active.data();
    b.iterations = iterations.data();
    b.jacobian = jacobian.data();
    if (!s.jacobians) b.pose = pose.data();
  }

  void solve(std::ptrdiff_t first, std::ptrdiff_t last_row) {
    BatchScratch scratch(n, b.metric.joints != nullptr);
    kernel().batch(b, first, last_row, scratch.memory());
  }

  // Row by row with the single tick's function, from the Jacobian that the batch gave.
  void compare() const {
    Scratch scratch(n, b.metric.joints != nullptr);
    for (int row = 0; row < count; ++row) {
      if (status[row] == stillreach::INVALID_INPUT) {
        CHECK(is_no_question(row));
        continue;
      }
      CHECK(!is_no_question(row));
      std::vector<double> J(n * m), own(n), left(m), asked(m);
      std::vector<std::int8_t> bound(n, 0);
      for (int i = 0; i < n; ++i)
        for (int r = 0; r < m; ++r) J[m * i + r] = jacobian[(row * m + r) * n + i];
      for (int r = 0; r < m; ++r) asked[r] = twist[row * b.twist_stride + (b.jacobians ? r : b.rows[r])];
      const stillreach::Problem p{m,
                                  n,
                                  J.data(),
                                  asked.data(),
                                  b.lower + row * b.bounds_stride,
                                  b.upper + row * b.bounds_stride,
                                  b.reference ? b.reference + row * n : nullptr,
                                  b.metric};
      stillreach::Answer a{own.data(), left.data(), bound.data(), 0, 0, 0.0, 1.0, 0.0};
      kernel().solve(b.law, p, scratch.view(), a);
      CHECK(std::memcmp(own.data(), &rates[row * n], sizeof(double) * n) == 0);
      CHECK(std::memcmp(left.data(), &residual[row * m], sizeof(double) * m) == 0);
      for (int i = 0; i < n; ++i) CHECK(active[row * n + i] == stillreach::bound_reason(bound[i]));
      CHECK(a.status == status[row]);
      CHECK(a.damping == damping[row] && a.scale == scale[row] && a.task_error == task_error[row] &&
            a.iterations == iterations[row]);
    }
  }

  bool is_no_question(int row) const {
    bool no = false;
    for (int r = 0; r < b.twist_stride; ++r) no |= !std::isfinite(twist[row * b.twist_stride + r]);
    for (int i = 0; i < n; ++i) no |= !(b.lower[row * b.bounds_stride + i] <= b.upper[row * b.bounds_stride + i]);
    return no;
  }

  bool inside() const {
    for (int row = 0; row < count; ++row)
      for (int i = 0; i < n && status[row] != stillreach::INVALID_INPUT; ++i) {
        const double rate = rates[row * n + i];
        if (!(rate >= b.lower[row * b.bounds_stride + i] && rate <= b.upper[row * b.bounds_stride + i])) return false;
      }
    return true;
  }
};

std::vector<Setting> settings() {
  std::vector<Setting> all(8);
  all[1].rows = {0, 1, 2};
  all[1].units = true;
  all[2].rows = {1, 3};
  all[2].per_row = false;
  all[3].tool_axes = true;
  all[3].limits = true;
  all[4].joint_matrix = true;
  all[4].reference = true;
  all[5].jacobians = true;
  all[6].jacobians = true;
  all[6].rows = {0, 1, 2};
  all[6].per_row = false;
  all[6].units = true;
  all[7].limits = true;
  all[7].units = true;
  return all;
}

void every_law_in_every_setting() {
  std::uint64_t seed = 1;
  for (const NamedLaw& law : every_law())
    for (const Setting& s : settings())
      for (const Chain& chain : {paper_chain(), snake_chain(6), planar_chain(3), skew_chain(7, 5), planar_chain(1)}) {
        Rows rows(chain, law.settings, s, 1 + static_cast<int>(seed % 21), seed);
        ++seed;
        rows.solve(0, rows.count);
        if (!s.limits && !s.tool_axes) rows.compare();
        CHECK(rows.inside() || !law.inside);
      }
}

void more_rows_than_are_worked_on_together() {
  for (const NamedLaw& law : every_law())
    for (int count : {255, 256, 257}) {
      Rows rows(snake_chain(8), law.settings, Setting(), count, 90 + count);
      rows.solve(0, count);
      rows.compare();
    }
}

void long_arms() {
  for (const NamedLaw& law : every_law()) {
    Rows rows(snake_chain(500), law.settings, Setting(), 5, 40);
    rows.solve(0, 5);
    rows.compare();
  }
}

void only_the_rows_asked_for_are_written() {
  for (const NamedLaw& law : every_law()) {
    Rows rows(paper_chain(), law.settings, Setting(), 20, 60);
    rows.solve(7, 13);
    for (int row = 0; row < 20; ++row) {
      const bool asked = row >= 7 && row < 13;
      CHECK((rows.status[row] == 7) != asked);
      CHECK((rows.damping[row] == 7.0 && rows.task_error[row] == 7.0 && rows.iterations[row] == 7) != asked);
      for (int i = 0; i < 11; ++i) CHECK(asked || (rows.rates[row * 11 + i] == 7.0 && rows.active[row * 11 + i] == 7));
      for (int i = 0; i < 66; ++i) CHECK(asked || rows.jacobian[row * 66 + i] == 7.0);
    }
  }
}

void nothing_but_rates_and_status_is_enough() {
  for (const NamedLaw& law : every_law()) {
    Rows rows(paper_chain(), law.settings, Setting(), 13, 70);
    rows.solve(0, 13);
    const std::vector<double> expected = rows.rates;
    rows.b.residual = rows.b.damping = rows.b.scale = rows.b.task_error = rows.b.pose = rows.b.jacobian = nullptr;
    rows.b.active = nullptr;
    rows.b.iterations = nullptr;
    rows.solve(0, 13);
    CHECK(std::memcmp(expected.data(), rows.rates.data(), sizeof(double) * expected.size()) == 0);
  }
}

// Poses, Jacobians and singular values of `count` rows; as the single function has them, and det(J J') by elimination.
void kinematics(const Chain& chain, int count, bool joint_matrix) {
  const int n = chain.n(), k = n > 2 ? n - 1 : n, most = k < 6 ? k : 6;
  const stillreach::ArmMemory arm = chain.arm();
  std::vector<double> pose(16 * count), jacobian(6 * n * count), sigma(most * count), product(count);
  const std::vector<double> q = Random(n + count).vector(n * count, 2.0), weight = coupling_matrix(n), units(n, 1.0);
  std::vector<int> joints(k);
  for (int j = 0; j < k; ++j) joints[j] = n - 1 - j;
  stillreach::KinematicsBatch b{};
  b.arm = arm.view();
  b.q = q.data();
  b.pose = pose.data();
  b.jacobian = jacobian.data();
  b.singular_values = sigma.data();
  b.manipulability = product.data();
  b.m = 6;
  b.joints = joints.data();
  b.count = k;
  for (int r = 0; r < 6; ++r) b.rows[r] = r;
  if (joint_matrix) b.metric = {nullptr, units.data(), units.data(), weight.data()};
  Aligned doubles(kernel().kinematics_doubles(n, k, joint_matrix));
  kernel().kinematics_rows(b, 0, count, doubles.data);
  std::vector<double> scratch(10 * n), J(6 * n);
  for (int row = 0; row < count; ++row) {
    double frame[12], squares = 0.0, entries = 0.0;
    kernel().kinematics(b.arm, &q[row * n], scratch.data(), frame, J.data());
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < 6; ++r) CHECK(J[6 * i + r] == jacobian[(row * 6 + r) * n + i]);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) CHECK(frame[3 * c + r] == pose[16 * row + 4 * r + c]);
    for (int j = 0; j < most; ++j) squares += sigma[row * most + j] * sigma[row * most + j];
    for (int j : joints)
      for (int r = 0; r < 6; ++r) entries += J[6 * j + r] * J[6 * j + r];
    if (!joint_matrix) CHECK_NEAR(squares, entries, 1e-12 * entries);  // both are the Frobenius norm
    for (int j = 1; j < most; ++j) CHECK(sigma[row * most + j] <= sigma[row * most + j - 1]);
    CHECK(k >= 6 || product[row] == 0.0);
  }
}

}  // namespace

int main() {
  every_law_in_every_setting();
  more_rows_than_are_worked_on_together();
  long_arms();
  only_the_rows_asked_for_are_written();
  nothing_but_rates_and_status_is_enough();
  for (int count : {1, 3, 4, 5, 9})
    for (bool joint_matrix : {false, true})
      for (const Chain& chain :
           {paper_chain(), planar_chain(1), snake_chain(2), snake_chain(6), skew_chain(9, 3), snake_chain(120)})
        kinematics(chain, count, joint_matrix);
  return finish("batch");
}
