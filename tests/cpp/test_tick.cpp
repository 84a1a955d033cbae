// The control tick as a robot's C++ loop calls it: hand-solved arms, faults, limits, bad encoders, tasks, long arms.
#include "check.hpp"
#include "robot.hpp"

namespace {

const double kStill[6] = {0, 0, 0, 0, 0, 0};

Options position_task(double rate = 100.0) {
  Options o;
  o.rows = {0, 1};
  o.rate = rate;
  return o;
}

// The planar arm's 2 x n Jacobian, column by column: (-y, x) of the tool seen from each joint.
std::vector<double> planar_jacobian(const std::vector<double>& q) {
  const int n = static_cast<int>(q.size());
  std::vector<double> J(2 * n, 0.0);
  for (int i = 0; i < n; ++i) {
    double angle = 0.0;
    for (int j = 0; j < n; ++j) {
      angle += q[j];
      if (j >= i) {
        J[2 * i] -= std::sin(angle);
        J[2 * i + 1] += std::cos(angle);
      }
    }
  }
  return J;
}

// Least-norm rates J' (J J')^-1 v over the joints that work, with the 2 x 2 inverse written out.
std::vector<double> planar_rates(const std::vector<double>& J, const double* v, const std::vector<bool>& works) {
  const int n = static_cast<int>(works.size());
  double a = 0.0, b = 0.0, c = 0.0;
  for (int i = 0; i < n; ++i)
    if (works[i]) {
      a += J[2 * i] * J[2 * i];
      b += J[2 * i] * J[2 * i + 1];
      c += J[2 * i + 1] * J[2 * i + 1];
    }
  const double det = a * c - b * b, x = (c * v[0] - b * v[1]) / det, y = (a * v[1] - b * v[0]) / det;
  std::vector<double> rates(n, 0.0);
  for (int i = 0; i < n; ++i)
    if (works[i]) rates[i] = J[2 * i] * x + J[2 * i + 1] * y;
  return rates;
}

bool reaches_the_task(const NamedLaw& law) {  // exactly, where the bounds allow it
  return !(law.settings.kind == stillreach::LawKind::SINGULARITY_ROBUST &&
           law.settings.damping == stillreach::DampingKind::NUMBER);
}

void planar_arms_by_hand() {
  const double twist[6] = {0.3, -0.2, 0, 0, 0, 0};
  const std::vector<double> pose = {0.4, 0.9, -0.6, 1.1};
  for (const NamedLaw& law : every_law())
    for (int n : {2, 4})
      for (int failed = n == 4 ? 3 : -1; failed >= -1; --failed) {
        if (!reaches_the_task(law)) continue;
        const std::vector<double> q(pose.begin(), pose.begin() + n);
        std::vector<bool> works(n, true);
        Robot robot(planar_chain(n), law.settings, position_task());
        if (failed >= 0) {
          robot.fail(failed);
          works[failed] = false;
        }
        robot.tick(q.data(), twist);
        const std::vector<double> expected = planar_rates(planar_jacobian(q), twist, works);
        for (int i = 0; i < n; ++i) CHECK_NEAR(robot.rates[i], expected[i], 1e-13);
        CHECK(robot.failed_joints_keep_their_rates());
        CHECK_NEAR(robot.answer.task_error, 0.0, 1e-14);
        if (failed < 0) continue;
        robot.restore(failed);
        robot.tick(q.data(), twist);
        const std::vector<double> healthy = planar_rates(planar_jacobian(q), twist, std::vector<bool>(n, true));
        for (int i = 0; i < n; ++i) CHECK_NEAR(robot.rates[i], healthy[i], 1e-13);
      }
}

// The paper's second example: 100 in towards -y in 20 s, joints 2, 4 and 7 failed, 50 deg/s.
void paper_arm_keeps_its_limit() {
  const double twist[6] = {0, -0.127, 0, 0, 0, 0};
  for (const NamedLaw& law : every_law()) {
    Options o;
    o.rate = 50 * kDegree;
    Robot robot(paper_chain(), law.settings, o);
    std::vector<double> q = {0, 0.2, 0, 0.5, 0, -1.0, 0, 0.7, 0.1, 0.3, 0};
    for (int joint : {1, 3, 6}) robot.fail(joint);
    for (int t = 0; t < 400; ++t) {
      robot.tick(q.data(), twist);
      CHECK(robot.finite());
      CHECK(robot.failed_joints_keep_their_rates());
      if (law.inside) CHECK(robot.inside());
      if (!law.inside) CHECK(robot.inside() == !(robot.answer.status & stillreach::OVER_LIMIT));
      for (int i = 0; i < robot.n; ++i) q[i] += 0.05 * robot.rates[i];
    }
  }
}

void all_joints_failed() {
  const double twist[6] = {1, 2, 3, 1, 2, 3};
  for (const NamedLaw& law : every_law())
    for (const Chain& chain : {planar_chain(3), paper_chain(), skew_chain(9, 1)}) {
      Robot robot(chain, law.settings);
      const std::vector<double> q = Random(1).vector(robot.n, 2.0);
      for (int i = 0; i < robot.n; ++i) robot.fail(i);
      robot.tick(q.data(), twist);
      CHECK(robot.answer.status & stillreach::NO_WORKING_JOINT);
      CHECK_NEAR(robot.answer.task_error, std::sqrt(28.0), 1e-14);
      for (double rate : robot.rates) CHECK(rate == 0.0);
    }
}

// A NaN from an encoder, or in the command: zero rates, or as near to them as the acceleration limit lets; failed
// joints keep their rates, and the next good tick is right again.
void not_a_number() {
  const double twist[6] = {0.1, 0.05, 0.2, 0.1, 0, 0};
  for (const NamedLaw& law : every_law())
    for (double bad : {std::nan(""), kInfinity, -kInfinity})
      for (int where = 0; where < 3; ++where) {
        Robot robot(paper_chain(), law.settings), healthy(paper_chain(), law.settings);
        const std::vector<double> q = Random(2).vector(11, 1.0);
        std::vector<double> broken = q;
        double command[6] = {0.1, 0.05, 0.2, 0.1, 0, 0}, target[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
        (where == 0 ? broken[3] : where == 1 ? command[4] : target[7]) = bad;
        robot.fail(5, stillreach::Health::RUNAWAY, 0.02);
        healthy.fail(5, stillreach::Health::RUNAWAY, 0.02);
        const std::int32_t status = robot.tick(broken.data(), command, where == 2 ? target : nullptr);
        CHECK(status == stillreach::INVALID_INPUT);
        for (int i = 0; i < 11; ++i) CHECK(robot.rates[i] == (i == 5 ? 0.02 : 0.0));
        robot.tick(q.data(), twist);
        healthy.tick(q.data(), twist);
        for (int i = 0; i < 11; ++i) CHECK(robot.rates[i] == healthy.rates[i]);
      }
}

void brakes_within_the_acceleration_limit() {
  Options o;
  o.acceleration = 2.0;
  o.period = 0.01;
  Robot robot(paper_chain(), law_settings(stillreach::LawKind::LEAST_ERROR), o);
  for (int i = 0; i < 11; ++i) robot.last[i] = i % 2 ? 0.5 : -0.01;
  const std::vector<double> q(11, std::nan(""));
  robot.tick(q.data(), kStill);
  for (int i = 0; i < 11; ++i) CHECK_NEAR(robot.rates[i], i % 2 ? 0.48 : 0.0, 1e-15);
}

void faults_become_bounds() {
  const double twist[6] = {0.4, 0.3, 0, 0, 0, 0};
  const std::vector<double> q = {0.4, 0.9, -0.6, 1.1};
  for (const NamedLaw& law : every_law()) {
    Robot robot(planar_chain(4), law.settings, position_task(2.0));
    robot.fail(0, stillreach::Health::DERATED, 0.05);
    robot.fail(2, stillreach::Health::RUNAWAY, -0.3);
    robot.tick(q.data(), twist);
    CHECK(robot.lower[0] == -0.1 && robot.upper[0] == 0.1);
    CHECK(robot.rates[2] == -0.3);
    CHECK(robot.lower_reason[0] == code(stillreach::Reason::FAULT) &&
          robot.lower_reason[1] == code(stillreach::Reason::RATE));
    if (law.inside) CHECK(robot.inside());
  }
}

void runaway_is_compensated_or_said() {
  const std::vector<double> q = {0.4, 0.9, -0.6, 1.1};
  Robot robot(planar_chain(4), law_settings(stillreach::LawKind::LEAST_ERROR), position_task(2.0));
  robot.fail(0, stillreach::Health::RUNAWAY, 0.2);
  robot.tick(q.data(), kStill);
  CHECK_NEAR(robot.answer.task_error, 0.0, 1e-14);
  CHECK(!(robot.answer.status & stillreach::FAULT_NOT_COMPENSATED));
  for (int i : {1, 2, 3}) robot.fail(i);
  robot.tick(q.data(), kStill);
  CHECK(robot.answer.status & stillreach::FAULT_NOT_COMPENSATED);
  CHECK(robot.failed_joints_keep_their_rates());
}

// No joint passes a position limit of 0.3 rad, and none asks for more deceleration than it has.
void position_limits_are_not_passed() {
  const double twist[6] = {0, 1.5, 0, 0, 0, 0};
  for (const NamedLaw& law : every_law()) {
    if (!law.inside) continue;
    Options o = position_task(2.0);
    o.position = 0.3;
    o.acceleration = 5.0;
    o.period = 0.01;
    Robot robot(planar_chain(4), law.settings, o);
    std::vector<double> q(4, 0.0);
    for (int t = 0; t < 300; ++t) {
      const std::vector<double> before(robot.rates.begin(), robot.rates.end());
      robot.tick(q.data(), twist);
      CHECK(robot.inside());
      CHECK(!(robot.answer.status & stillreach::LIMIT_GIVEN_UP));
      for (int i = 0; i < 4; ++i) {
        CHECK(std::fabs(robot.rates[i] - before[i]) <= o.acceleration * o.period * (1 + 1e-12));
        q[i] += o.period * robot.rates[i];
        CHECK(std::fabs(q[i]) <= 0.3 + 1e-12);
      }
    }
  }
}

// Any choice of rows, along base or tool axes: the chosen part of the twist is met, and is what the report says.
void every_choice_of_rows() {
  const double twist[6] = {0.02, -0.03, 0.04, 0.05, -0.01, 0.03};
  const std::vector<double> q = Random(7).vector(11, 1.2);
  for (const NamedLaw& law : every_law())
    for (int tool = 0; tool < 2; ++tool)
      for (int mask = 1; mask < 64; ++mask) {
        Options o;
        o.rows.clear();
        o.tool_axes = tool != 0;
        for (int r = 0; r < 6; ++r)
          if (mask >> r & 1) o.rows.push_back(r);
        Robot robot(paper_chain(), law.settings, o);
        robot.tick(q.data(), twist);
        double tip[6] = {};  // what the tool does, along base axes
        for (int i = 0; i < 11; ++i)
          for (int r = 0; r < 6; ++r) tip[r] += robot.jacobian[6 * i + r] * robot.rates[i];
        for (int r = 0; r < robot.m; ++r) {
          const int h = o.rows[r] < 3 ? 0 : 3, axis = o.rows[r] - h;
          double off = 0.0;
          for (int i = 0; i < 3; ++i)
            off += (tool ? robot.state.now.pose[3 * axis + i] : i == axis) * (twist[h + i] - tip[h + i]);
          CHECK_NEAR(robot.residual[r], off, 1e-14);
          if (reaches_the_task(law)) CHECK_NEAR(off, 0.0, 1e-12);
        }
      }
}

void full_joint_weights_and_null_motions() {
  Random random(8);
  for (const NamedLaw& law : every_law())
    for (int n : {1, 2, 6, 7, 11, 40})
      for (int null_kind = 0; null_kind <= 7; ++null_kind)
        for (int m : {1, 3, 5, 6}) {
          Options o;
          o.joint_matrix = (n + m) % 2 != 0;
          o.null_kind = static_cast<stillreach::NullMotionKind>(null_kind);
          o.null_failures = 1 + (n + m) % 3;
          o.position = 3.0;
          o.transition_rate = 2.0;
          o.rows.resize(m);
          Robot robot(skew_chain(n, 9 + n), law.settings, o);
          for (int t = 0; t < 4; ++t) {
            if (t == 1) robot.fail(random.below(n));
            if (t == 2) robot.fail(random.below(n), stillreach::Health::DERATED, 0.1);
            const std::vector<double> q = random.vector(n, 2.0), twist = random.vector(6, 2.0);
            robot.tick(q.data(), twist.data());
            CHECK(robot.finite());
            CHECK(robot.failed_joints_keep_their_rates());
            if (law.inside) CHECK(robot.inside());
          }
        }
}

void long_arm() {
  for (const NamedLaw& law : every_law())
    for (const stillreach::NullMotionKind null_kind :
         {stillreach::NullMotionKind::NONE, stillreach::NullMotionKind::MANIPULABILITY,
          stillreach::NullMotionKind::TOLERANCE, stillreach::NullMotionKind::GUARANTEED_SPEED}) {
      Options o;
      o.null_kind = null_kind;
      Robot robot(snake_chain(500), law.settings, o);
      Random random(9);
      std::vector<double> q = random.vector(500, 0.1);
      for (int i = 0; i < 500; i += 9) robot.fail(i);
      for (double speed : {1.0, 500.0}) {
        const double twist[6] = {speed, -speed, speed, 0, 0.1, 0};
        robot.tick(q.data(), twist);
        CHECK(robot.finite());
        CHECK(robot.failed_joints_keep_their_rates());
        if (law.inside) CHECK(robot.inside());
        if (speed == 1.0 && reaches_the_task(law)) CHECK_NEAR(robot.answer.task_error, 0.0, 1e-10);
      }
    }
}

// Closing the loop on a pose half a turn away: the tool ends there.
void tracking_ends_at_the_target() {
  Options o;
  o.rate = 5.0;
  Robot robot(skew_chain(9, 21),
              law_settings(stillreach::LawKind::LEAST_ERROR, stillreach::DampingKind::NUMBER,
                           stillreach::NormKind::MAXIMUM, 0.0, 10.0),
              o);
  std::vector<double> q = Random(22).vector(9, 0.5), goal = q;
  goal[0] += 0.5;
  goal[4] -= 0.4;
  goal[7] += 0.3;
  robot.tick(goal.data(), kStill);
  double target[12];
  std::memcpy(target, robot.state.now.pose, sizeof target);
  for (int t = 0; t < 1000; ++t) {
    robot.tick(q.data(), kStill, target);
    for (int i = 0; i < 9; ++i) q[i] += 0.01 * robot.rates[i];
  }
  for (int i = 0; i < 12; ++i) CHECK_NEAR(robot.state.now.pose[i], target[i], 1e-6);
}

// From 1 rad/s to a new limit of 0.3: by 0.02 a tick, the acceleration limit; a fault does not wait.
void new_limits_close_in() {
  Options o;
  o.acceleration = 2.0;
  o.period = 0.01;
  o.rows = {5};
  Robot robot(planar_chain(1), law_settings(stillreach::LawKind::LEAST_ERROR), o);
  const double twist[6] = {0, 0, 0, 0, 0, 5}, q[1] = {0.0};
  robot.last[0] = 1.0;
  stillreach::ControllerMemory::writable(robot.state.settings.rate_upper)[0] = 0.3;
  robot.core.limits_changed(stillreach::CLOSING_RATE);
  for (int t = 1; t <= 20; ++t) {
    CHECK(!(robot.tick(q, twist) & stillreach::LIMIT_GIVEN_UP));
    CHECK_NEAR(robot.rates[0], 1.0 - 0.02 * t, 1e-12);
  }
  robot.fail(0, stillreach::Health::DERATED, 0.5);
  CHECK(robot.tick(q, twist) & stillreach::LIMIT_GIVEN_UP);
  CHECK_NEAR(robot.rates[0], 0.15, 1e-15);
}

// v period + v^2 / (2 a) = room, at 1 rad/s, 0.1 s and 2 rad/s^2 a room of 0.35 rad.
void uneven_periods_brake_earlier() {
  Options o;
  o.acceleration = 2.0;
  o.period = 0.1;
  o.rows = {5};
  o.position = 0.35;
  o.rate = 9.0;
  Robot robot(planar_chain(1), law_settings(stillreach::LawKind::LEAST_ERROR), o);
  const double twist[6] = {0, 0, 0, 0, 0, 5}, q[1] = {0.0};
  robot.last[0] = 1.0;
  robot.core.tick(q, twist, nullptr, o.period);
  CHECK_NEAR(robot.rates[0], 1.0, 1e-12);
}

// One joint that turns about the task's axis, pushed at 5 rad/s; at 1 rad/s at most, within 2 rad/s^2.
Options one_joint(double period) {
  Options o;
  o.rows = {5};
  o.acceleration = 2.0;
  o.period = period;
  return o;
}
const double kPush[6] = {0, 0, 0, 0, 0, 5};

void a_confined_joint_stops_inside_and_comes_back_from_outside() {
  for (const double period : {0.001, 0.002, 0.005, 0.01})
    for (const double side : {1.0, -1.0}) {
      Robot robot(planar_chain(1), law_settings(stillreach::LawKind::LEAST_ERROR), one_joint(period));
      robot.fail(0, stillreach::Health::CONFINED, -0.4, 0.4);
      double q[1] = {0.0}, twist[6] = {0, 0, 0, 0, 0, side * kPush[5]}, before = 0.0;
      for (double t = 0.0; t < 2.0; t += period) {
        CHECK(!(robot.tick(q, twist) & stillreach::LIMIT_GIVEN_UP));
        CHECK(std::fabs(robot.rates[0] - before) <= 2.0 * period * (1 + 1e-9));
        before = robot.rates[0];
        q[0] += period * robot.rates[0];
        CHECK(side * q[0] <= 0.4 + 1e-12);
      }
      CHECK(side * q[0] > 0.399);
      q[0] = side * 0.7;  // outside, at rest
      robot.last[0] = 0.0;
      robot.tick(q, twist);
      CHECK(robot.rates[0] == 0.0 && robot.lower[0] <= 0.0 && robot.upper[0] >= 0.0);
      for (double& w : twist) w = -w;
      for (double t = 0.0; t < 2.0; t += period) {
        robot.tick(q, twist);
        CHECK(side * robot.rates[0] <= 0.0);
        q[0] += period * robot.rates[0];
      }
      CHECK(std::fabs(q[0]) <= 0.4 + 1e-12);
    }
}

void a_one_way_joint_never_turns_back() {
  for (const double side : {1.0, -1.0}) {
    Robot robot(planar_chain(1), law_settings(stillreach::LawKind::LEAST_ERROR), one_joint(0.01));
    const double q[1] = {0.0}, back[6] = {0, 0, 0, 0, 0, -side * kPush[5]};
    robot.last[0] = side * 0.05;
    robot.fail(0, stillreach::Health::ONE_WAY, side);
    for (const double expected : {0.03, 0.01, 0.0, 0.0}) {
      CHECK(!(robot.tick(q, back) & stillreach::LIMIT_GIVEN_UP));
      CHECK_NEAR(side * robot.rates[0], expected, 1e-15);
    }
    robot.last[0] = -side * 0.5;  // it was on its way to the other side when it failed
    CHECK(robot.tick(q, back) & stillreach::LIMIT_GIVEN_UP);
    CHECK(robot.rates[0] == 0.0);
  }
}

void rounded_poses_become_rigid() {
  const float c = std::cos(0.7f), s = std::sin(0.7f);
  const double T[16] = {c, -s, 0, 1, s, c, 0, 2, 0, 0, 1, 3, 0, 0, 1e-7, 1};
  double pose[12], worse[16];
  CHECK(kernel().read_pose(T, pose));
  CHECK_NEAR(pose[0] * pose[0] + pose[1] * pose[1], 1.0, 1e-15);
  CHECK_NEAR(pose[0] * pose[3] + pose[1] * pose[4], 0.0, 1e-15);
  CHECK_NEAR(pose[0], c, 1e-7);
  CHECK(pose[9] == 1 && pose[10] == 2 && pose[11] == 3);
  for (double wrong : {1e-4, std::nan(""), kInfinity, -2.0, 1e200})
    for (int at : {0, 6, 10, 12, 15}) {
      std::memcpy(worse, T, sizeof T);
      worse[at] += wrong;
      CHECK(!kernel().read_pose(worse, pose));
    }
}

}  // namespace

int main() {
  planar_arms_by_hand();
  paper_arm_keeps_its_limit();
  all_joints_failed();
  not_a_number();
  brakes_within_the_acceleration_limit();
  faults_become_bounds();
  runaway_is_compensated_or_said();
  position_limits_are_not_passed();
  every_choice_of_rows();
  full_joint_weights_and_null_motions();
  long_arm();
  tracking_ends_at_the_target();
  new_limits_close_in();
  uneven_periods_brake_earlier();
  a_confined_joint_stops_inside_and_comes_back_from_outside();
  a_one_way_joint_never_turns_back();
  rounded_poses_become_rigid();
  return finish("tick");
}
