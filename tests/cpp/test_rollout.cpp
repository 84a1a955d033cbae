// Chunks of simulated ticks: what is recorded, and how far Euler's and Runge-Kutta's steps are off.
#include "check.hpp"
#include "robot.hpp"

namespace {

// A record exactly as long as `steps` rows of n joints need, and what else a chunk needs.
struct Rollout : stillreach::Record {
  long steps;
  std::vector<std::vector<char>> rows;
  std::vector<double> scratch;
  std::vector<std::int8_t> scratch_active;
  Rollout(int n, long count) : steps(count), scratch(4 * n), scratch_active(n) {
    stillreach::each_array(*this, n, [this](auto*& array, const char*, int row) {
      rows.emplace_back(sizeof(*array) * row * steps, '\xff');  // not a number
      array = reinterpret_cast<std::remove_reference_t<decltype(array)>>(rows.back().data());
    });
  }
  void run(Robot& robot, std::vector<double>& at, const std::vector<double>& twists, int stages, bool advance = true,
           const double* targets = nullptr) {
    kernel().rollout(robot.state, at.data(), twists.data(), targets, steps, stages, advance, nullptr,
                     robot.core.workspace.view(), robot.answer, scratch.data(), scratch_active.data(), *this);
  }
};

std::vector<double> constant_twists(long rows, const double* twist) {
  std::vector<double> twists;
  for (long t = 0; t < rows; ++t) twists.insert(twists.end(), twist, twist + 6);
  return twists;
}

// How far the tool of a planar 2R arm is from where a straight, steady motion ends, after 1 s in `steps` steps.
double end_error(long steps, int stages) {
  Options o;
  o.rows = {0, 1};
  o.rate = 100.0;
  o.period = 1.0 / static_cast<double>(steps);
  Robot robot(planar_chain(2), law_settings(stillreach::LawKind::PSEUDOINVERSE), o);
  std::vector<double> q = {0.3, 1.2};
  const double twist[6] = {-0.6, 0.1, 0, 0, 0, 0}, x = std::cos(0.3) + std::cos(1.5), y = std::sin(0.3) + std::sin(1.5);
  Rollout r(2, steps);
  r.run(robot, q, constant_twists(stages * steps + 1, twist), stages);
  return std::hypot(std::cos(q[0]) + std::cos(q[0] + q[1]) - x + 0.6, std::sin(q[0]) + std::sin(q[0] + q[1]) - y - 0.1);
}

void steps_are_of_first_and_fourth_order() {
  const double euler = end_error(100, 1) / end_error(200, 1), rk4 = end_error(20, 2) / end_error(40, 2);
  CHECK(euler > 1.9 && euler < 2.1);
  CHECK(rk4 > 13.0 && rk4 < 19.0);
  CHECK(end_error(100, 2) < 1e-8);
}

// An Euler chunk is its ticks, one by one, to the last bit; and two chunks are one.
void chunk_is_its_ticks() {
  const double twist[6] = {0.3, -0.2, 0.3, 0.1, -0.1, 0.2};
  for (const NamedLaw& law : every_law()) {
    Options o;
    o.period = 0.01;
    o.position = 2.5;
    o.transition_rate = 2.0;
    Robot whole(paper_chain(), law.settings, o), halves(paper_chain(), law.settings, o),
        ticks(paper_chain(), law.settings, o);
    const std::vector<double> start = Random(1).vector(11, 1.0);
    std::vector<double> a = start, b = start, c = start;
    for (Robot* robot : {&whole, &halves, &ticks}) {
      robot->fail(3);
      robot->fail(6, stillreach::Health::DERATED, 0.2);
    }
    Rollout one(11, 40), first(11, 20), second(11, 20);
    one.run(whole, a, constant_twists(40, twist), 1);
    first.run(halves, b, constant_twists(20, twist), 1);
    second.run(halves, b, constant_twists(20, twist), 1);
    for (long t = 0; t < 40; ++t) {
      const std::int32_t status = ticks.tick(c.data(), twist);
      CHECK(one.status[t] == status && (t < 20 ? first.status[t] : second.status[t - 20]) == status);
      CHECK(one.task_error[t] == ticks.answer.task_error && one.damping[t] == ticks.answer.damping);
      for (int i = 0; i < 11; ++i) {
        CHECK(one.rates[11 * t + i] == ticks.rates[i]);
        CHECK(one.lower[11 * t + i] == ticks.lower[i] &&
              one.health[11 * t + i] == static_cast<std::int8_t>(ticks.faults[i].health));
        c[i] = t < 39 ? one.q[11 * (t + 1) + i] : a[i];  // with or without a fused multiply-add:
        CHECK_NEAR(c[i], one.q[11 * t + i] + o.period * ticks.rates[i], 1e-15);
      }
    }
    for (int i = 0; i < 11; ++i) CHECK(a[i] == b[i]);
  }
}

void records_without_moving() {
  const double twist[6] = {0.1, 0, 0.1, 0, 0, 0};
  for (int stages : {1, 2}) {
    Robot robot(paper_chain(), law_settings(stillreach::LawKind::LEAST_ERROR));
    std::vector<double> q = Random(2).vector(11, 1.0);
    const std::vector<double> before = q;
    Rollout r(11, 3);
    r.run(robot, q, constant_twists(3 * stages, twist), stages, false);
    CHECK(q == before);
    for (int i = 0; i < 33; ++i) CHECK(r.q[i] == before[i % 11]);
    for (int t = 0; t < 3; ++t) CHECK(r.pose[16 * t + 15] == 1.0 && r.pose[16 * t + 12] == 0.0);
  }
}

// Every law and both integrators, with faults, targets, a long arm: inside the bounds, failed joints where they were.
void promises_hold() {
  for (const NamedLaw& law : every_law())
    for (int stages : {1, 2})
      for (int n : {3, 11, 60}) {
        Options o;
        o.period = 0.02;
        o.null_kind = stillreach::NullMotionKind::MANIPULABILITY;
        Robot robot(skew_chain(n, 5), law.settings, o);
        std::vector<double> q = Random(6).vector(n, 1.0), before = q;
        const double twist[6] = {1.0, -2.0, 1.5, 0.5, 0, 1};
        const std::vector<double> twists = constant_twists(30 * stages + 1, twist);
        std::vector<double> targets;
        for (int t = 0; t <= 30 * stages; ++t) targets.insert(targets.end(), {0, 1, 0, -1, 0, 0, 0, 0, 1, 0.5, 0.5, 1});
        robot.fail(1);
        Rollout r(n, 30);
        r.run(robot, q, twists, stages, true, n == 11 ? targets.data() : nullptr);
        for (int t = 0; t < 30; ++t)
          for (int i = 0; i < n; ++i) {
            const int at = n * t + i;
            CHECK(std::isfinite(r.rates[at]));
            if (law.inside) CHECK(r.rates[at] >= r.lower[at] && r.rates[at] <= r.upper[at]);
          }
        CHECK(q[1] == before[1]);
      }
}

}  // namespace

int main() {
  steps_are_of_first_and_fourth_order();
  chunk_is_its_ticks();
  records_without_moving();
  promises_hold();
  return finish("rollout");
}
