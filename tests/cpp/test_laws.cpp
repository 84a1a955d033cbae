// Each law on Jacobians from anywhere: 1 to 6 rows, 0 to n working joints, every rank, weights, hard numbers.
#include "check.hpp"
#include "robot.hpp"

namespace {

struct Question {
  int m, n;
  std::vector<double> jacobian, twist, lower, upper, reference, rows, units, weight;
  Question(int rows_count, int joints)
      : m(rows_count), n(joints), jacobian(m * n), twist(m), lower(n, -1.0), upper(n, 1.0) {}
};

struct Reply {
  std::vector<double> rates, residual;
  std::vector<std::int8_t> active;
  stillreach::Answer answer{};
  explicit Reply(const Question& q) : rates(q.n, 99.0), residual(q.m), active(q.n) {}
};

void ask(const stillreach::LawSettings& law, const Question& q, Reply& r) {
  const auto at = [](const std::vector<double>& v) { return v.empty() ? nullptr : v.data(); };
  const stillreach::Metric metric{at(q.rows), at(q.units), at(q.units), at(q.weight)};
  const stillreach::Problem p{
      q.m, q.n, q.jacobian.data(), q.twist.data(), q.lower.data(), q.upper.data(), at(q.reference), metric};
  r.answer.rates = r.rates.data();
  r.answer.residual = r.residual.data();
  r.answer.active = r.active.data();
  Scratch scratch(q.n, !q.weight.empty());
  kernel().solve(law, p, scratch.view(), r.answer);
}

double largest(const std::vector<double>& v) {
  double size = 0.0;
  for (double x : v) size = std::fmax(size, std::fabs(x));
  return size;
}

// What holds for every law and question: finite, failed joints at exactly their rate, residual = twist - J rates, and
// inside the bounds where the law promises it.
void check_promises(const NamedLaw& law, const Question& q, const Reply& r) {
  bool right = true;
  for (int i = 0; i < q.n; ++i) {
    right &= std::isfinite(r.rates[i]);
    if (!(q.lower[i] < q.upper[i])) right &= r.rates[i] == q.lower[i];
    if (law.inside) right &= r.rates[i] >= q.lower[i] && r.rates[i] <= q.upper[i];
  }
  for (int row = 0; row < q.m; ++row) {
    double e = q.twist[row], size = std::fabs(e);
    for (int i = 0; i < q.n; ++i) {
      e -= q.jacobian[i * q.m + row] * r.rates[i];
      size += std::fabs(q.jacobian[i * q.m + row] * r.rates[i]);
    }
    right &= std::fabs(r.residual[row] - e) <= 1e-14 * size;
  }
  if (!right) std::fprintf(stderr, "law '%s', m = %d, n = %d\n", law.name, q.m, q.n);
  CHECK(right);
}

// A random question; `hardness` chooses what makes it hard.
Question random_question(Random& random, int m, int n, int hardness) {
  Question q(m, n);
  q.jacobian = random.vector(m * n, 1.0);
  q.twist = random.vector(m, 2.0);
  for (int i = 0; i < n; ++i) {
    q.lower[i] = -random.between(0.0, 1.0);
    q.upper[i] = random.between(0.0, 1.0);
  }
  if (hardness == 1)  // rank 1
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < m; ++r) q.jacobian[i * m + r] = q.jacobian[i * m] * (r + 1.0);
  if (hardness == 2)  // nearly so
    for (int i = 0; i < n; ++i)
      for (int r = 1; r < m; ++r) q.jacobian[i * m + r] = q.jacobian[i * m] * (r + 1.0) + 1e-8 * q.jacobian[i * m + r];
  if (hardness == 3) q.jacobian.assign(m * n, 0.0);
  if (hardness == 4) q.twist.assign(m, 0.0);
  if (hardness == 5)
    for (double& v : q.twist) v *= 1e300;
  if (hardness == 6)
    for (double& v : q.twist) v *= 1e-310;
  if (hardness == 7)
    for (double& v : q.jacobian) v *= 1e-200;
  if (hardness == 8)
    for (int i = 0; i < n; ++i) {
      q.lower[i] = -kInfinity;
      q.upper[i] = kInfinity;
    }
  if (hardness == 9)
    for (int i = 0; i < n; i += 2) q.lower[i] = 0.0;
  const int failed = random.below(n + 1);
  for (int f = 0; f < failed; ++f) {
    const int i = random.below(n);
    q.lower[i] = q.upper[i] = random.below(2) ? 0.0 : random.between(-0.5, 0.5);
  }
  return q;
}

void promises_hold_everywhere() {
  Random random(1);
  for (const NamedLaw& law : every_law())
    for (int m = 1; m <= 6; ++m)
      for (int n : {1, 2, 3, 5, 6, 7, 8, 11, 13})
        for (int hardness = 0; hardness < 10; ++hardness)
          for (int kind = 0; kind < 4; ++kind) {
            Question q = random_question(random, m, n, hardness);
            if (kind & 1) q.reference = random.vector(n, 0.5);
            if (kind & 2) {
              q.units.assign(n, 1.0);
              q.weight = coupling_matrix(n);
            }
            if (kind == 3) {  // and task weights: upper triangular, positive diagonal
              q.rows = random.vector(m * m, 0.5);
              for (int r = 0; r < m; ++r) q.rows[r * m + r] = 1.0 + r;
            }
            Reply r(q);
            ask(law.settings, q, r);
            check_promises(law, q, r);
            ask(law.settings, q, r);  // again: from the bounds that are active now
            check_promises(law, q, r);
          }
}

// The paper's laws with weights of any rank, whether eq. (8) has one answer or many.
void promises_hold_with_semidefinite_weights() {
  Random random(7);
  for (const NamedLaw& law : every_law()) {
    if (law.settings.kind != stillreach::LawKind::PSEUDOINVERSE &&
        law.settings.kind != stillreach::LawKind::SINGULARITY_ROBUST)
      continue;
    for (int m = 1; m <= 6; ++m)
      for (int n : {1, 2, 3, 6, 7, 11})
        for (int hardness = 0; hardness < 10; ++hardness)
          for (int rank = 0; rank <= n; ++rank) {
            Question q = random_question(random, m, n, hardness);
            if (rank & 1) q.reference = random.vector(n, 0.5);
            q.units.assign(n, 1.0);
            q.weight.assign(n * n, 0.0);
            for (int r = 0; r < rank; ++r) {
              const std::vector<double> root = random.vector(n, 1.0);
              for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) q.weight[i * n + j] += root[i] * root[j];
            }
            if (rank & 2) {
              q.rows.assign(m * m, 0.0);
              q.rows[0] = 2.0;
            }
            Reply r(q);
            ask(law.settings, q, r);
            check_promises(law, q, r);
          }
  }
}

void long_arms() {
  Random random(2);
  for (const NamedLaw& law : every_law())
    for (int weighted = 0; weighted < 2; ++weighted) {
      const int n = weighted ? 60 : 500;
      Question q(6, n);
      q.jacobian = random.vector(6 * n, 1.0);
      q.twist = random.vector(6, weighted ? 20.0 : 300.0);
      if (weighted) {
        q.units.assign(n, 1.0);
        q.weight = coupling_matrix(n);
      }
      for (int i = 0; i < n; i += 7) q.lower[i] = q.upper[i] = 0.0;
      Reply r(q);
      ask(law.settings, q, r);
      check_promises(law, q, r);
    }
}

void no_working_joint() {
  for (const NamedLaw& law : every_law()) {
    Question q(6, 7);
    q.jacobian = Random(3).vector(42, 1.0);
    q.twist = {1, 2, 3, 4, 5, 6};
    q.lower.assign(7, 0.0);
    q.upper.assign(7, 0.0);
    Reply r(q);
    ask(law.settings, q, r);
    check_promises(law, q, r);
    CHECK(r.answer.status & stillreach::NO_WORKING_JOINT);
    CHECK_NEAR(r.answer.task_error, std::sqrt(91.0), 1e-14);
  }
}

// An infinite or undefined Jacobian or twist cannot be answered; what comes back is finite and inside the bounds.
void not_a_number() {
  for (const NamedLaw& law : every_law())
    for (double bad : {std::nan(""), kInfinity, -kInfinity})
      for (int where = 0; where < 2; ++where) {
        Question q(6, 8);
        q.jacobian = Random(4).vector(48, 1.0);
        q.twist = {0.1, 0.2, 0.3, 0.1, 0.2, 0.3};
        (where ? q.twist[2] : q.jacobian[17]) = bad;
        Reply r(q);
        ask(law.settings, q, r);
        CHECK(r.answer.status & stillreach::INVALID_INPUT);
        for (double rate : r.rates) CHECK(rate >= -1.0 && rate <= 1.0);
      }
}

// One row, two joints: dq = J' twist / (J J') = (3, 4) / 5, its share of the twist where one of them is fixed.
void one_row_by_hand() {
  Question q(1, 2);
  q.jacobian = {3, 4};
  q.twist = {5};
  for (const NamedLaw& law : every_law()) {
    if (law.settings.damping == stillreach::DampingKind::NUMBER && law.settings.kappa > 0.0) continue;
    Reply free(q), fixed(q);
    ask(law.settings, q, free);
    CHECK_NEAR(free.rates[0], 0.6, 1e-15);
    CHECK_NEAR(free.rates[1], 0.8, 1e-15);
    Question failed = q;
    failed.lower[1] = failed.upper[1] = 0.5;  // a runaway: the other one makes up for it
    ask(law.settings, failed, fixed);
    CHECK_NEAR(fixed.rates[0], 1.0, 1e-15);
    CHECK(fixed.rates[1] == 0.5);
  }
  Reply damped(q);
  ask(law_settings(stillreach::LawKind::SINGULARITY_ROBUST, stillreach::DampingKind::NUMBER,
                   stillreach::NormKind::MAXIMUM, 25.0),
      q, damped);
  CHECK_NEAR(damped.rates[0], 0.3, 1e-15);  // J' twist / (J J' + 25)
  CHECK_NEAR(damped.rates[1], 0.4, 1e-15);
}

// Planar arm of four unit links at relative angles 20, 50, -30, 40 degrees, twist (1.8, 2.4), limits 0.5, 0.5, 1, 1.
void planar_arm_at_its_limits() {
  Question q(2, 4);
  const double angles[4] = {20 * kDegree, 70 * kDegree, 40 * kDegree, 80 * kDegree};
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) {
      q.jacobian[2 * i] -= std::sin(angles[j]);
      q.jacobian[2 * i + 1] += std::cos(angles[j]);
    }
  q.twist = {1.8, 2.4};
  q.upper = {0.5, 0.5, 1.0, 1.0};
  q.lower = {-0.5, -0.5, -1.0, -1.0};
  Reply kept(q), least(q);
  ask(law_settings(stillreach::LawKind::KEEP_DIRECTION), q, kept);
  CHECK_NEAR(kept.answer.scale, 0.2227372, 5e-8);
  CHECK(kept.answer.status & stillreach::SCALED);
  for (int r = 0; r < 2; ++r) CHECK_NEAR(kept.residual[r], (1.0 - kept.answer.scale) * q.twist[r], 1e-12);
  ask(law_settings(stillreach::LawKind::LEAST_ERROR), q, least);
  CHECK_NEAR(least.answer.task_error, 2.3150470, 5e-8);
  CHECK(least.answer.task_error < kept.answer.task_error);
}

// J = diag(1, 0.01) R(22.5 deg)', twist = J (1, 1): the largest rate falls to the limit for the first time at a damping
// factor that no smaller one on a fine grid meets.
void exact_damping_is_the_smallest() {
  const double c = std::cos(22.5 * kDegree), s = std::sin(22.5 * kDegree);
  Question q(2, 2);
  q.jacobian = {c, -0.01 * s, s, 0.01 * c};
  q.twist = {c + s, 0.01 * (c - s)};
  const double limit = 0.999;
  q.lower.assign(2, -limit);
  q.upper.assign(2, limit);
  Reply r(q);
  ask(law_settings(stillreach::LawKind::SINGULARITY_ROBUST, stillreach::DampingKind::EXACT), q, r);
  CHECK(largest(r.rates) <= limit && largest(r.rates) >= limit * (1.0 - 1e-9));
  const auto size = [&](double kappa) {  // of R diag(1, 0.01) / (sigma^2 + kappa) twist
    const double u = q.twist[0] / (1.0 + kappa), v = 0.01 * q.twist[1] / (1e-4 + kappa);
    return std::fmax(std::fabs(c * u - s * v), std::fabs(s * u + c * v));
  };
  CHECK_NEAR(size(r.answer.damping), largest(r.rates), 1e-12);
  for (double kappa = 0.0; kappa < r.answer.damping * (1.0 - 1e-6); kappa += r.answer.damping / 10000)
    CHECK(size(kappa) > limit);
}

// LeastError never leaves more task error than any other law that keeps the bounds, nor than any point of the box
// tried.
void least_error_is_least() {
  Random random(5);
  for (int trial = 0; trial < 300; ++trial) {
    const int m = 1 + random.below(6), n = 1 + random.below(12);
    Question q = random_question(random, m, n, random.below(3));
    Reply best(q);
    ask(law_settings(stillreach::LawKind::LEAST_ERROR), q, best);
    for (const NamedLaw& law : every_law()) {
      Reply r(q);
      ask(law.settings, q, r);
      if (law.inside) CHECK(best.answer.task_error <= r.answer.task_error + 1e-12);
    }
    for (int point = 0; point < 20; ++point) {  // steps from the answer to any point of the box
      const double step = random.between(0.0, 1.0);
      double sum = 0.0;
      std::vector<double> e = best.residual;
      for (int i = 0; i < n; ++i) {
        const double move = step * (random.between(q.lower[i], q.upper[i]) - best.rates[i]);
        for (int r = 0; r < m; ++r) e[r] -= q.jacobian[i * m + r] * move;
      }
      for (double v : e) sum += v * v;
      CHECK(best.answer.task_error <= std::sqrt(sum) + 1e-12);
    }
  }
}

// Six equal rows asked for as 6, and the first three of them as 3: rows that no joint serves change nothing.
void idle_rows_change_nothing() {
  Random random(6);
  for (const NamedLaw& law : every_law()) {
    Question three = random_question(random, 3, 7, 0), six(6, 7);
    six.lower = three.lower;
    six.upper = three.upper;
    for (int r = 0; r < 3; ++r) six.twist[r] = three.twist[r];
    for (int i = 0; i < 7; ++i)
      for (int r = 0; r < 3; ++r) six.jacobian[6 * i + r] = three.jacobian[3 * i + r];
    Reply a(three), b(six);
    ask(law.settings, three, a);
    ask(law.settings, six, b);
    for (int i = 0; i < 7; ++i) CHECK_NEAR(a.rates[i], b.rates[i], 1e-10);
  }
}

}  // namespace

int main() {
  promises_hold_everywhere();
  promises_hold_with_semidefinite_weights();
  long_arms();
  no_working_joint();
  not_a_number();
  one_row_by_hand();
  planar_arm_at_its_limits();
  exact_damping_is_the_smallest();
  least_error_is_least();
  idle_rows_change_nothing();
  return finish("laws");
}
