// The front door computes what the core does, refuses what is wrong, and never throws in
// the loop.
#include "check.hpp"
#include "robot.hpp"
#include "stillreach/stillreach.hpp"

namespace {

using stillreach::Arm;
using stillreach::Controller;
using stillreach::Joint;

std::vector<Joint> joints_of(const Chain& chain, const Options& o) {
  std::vector<Joint> joints(chain.kinds.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    std::copy_n(chain.placements.data() + 16 * i, 16, joints[i].placement.T);
    std::copy_n(chain.axes.data() + 3 * i, 3, joints[i].axis);
    joints[i].kind = chain.kinds[i];
    joints[i].velocity_limit = o.rate;
    joints[i].lower = -o.position;
    joints[i].upper = o.position;
    joints[i].acceleration_limit = o.acceleration;
    joints[i].name = "j" + std::to_string(i + 1);
  }
  return joints;
}

stillreach::Pose tool_of(const Chain& chain) {
  stillreach::Pose tool;
  std::copy_n(chain.placements.data() + 16 * chain.kinds.size(), 16, tool.T);
  return tool;
}

Controller controller_of(const Chain& chain, const stillreach::LawSettings& law, const Options& o) {
  stillreach::Options options;
  options.law = law;
  options.rows = o.rows;
  options.tool_axes = o.tool_axes;
  options.period = o.period;
  options.transition_rate = o.transition_rate;
  options.null_motion = o.null_kind;
  options.null_gain = options.null_largest = 0.5;
  options.null_vector.assign(chain.kinds.size(), 0.25);
  return Controller(Arm(joints_of(chain, o), tool_of(chain)), options);
}

void the_same_bits_as_the_core() {
  int laws = 0;
  for (const NamedLaw& law : every_law())
    for (int variant = 0; variant < 6; ++variant) {
      Options o;
      o.period = 0.01;
      o.position = variant % 2 ? 2.0 : kInfinity;
      o.acceleration = variant % 3 == 1 ? 20.0 : kInfinity;
      o.transition_rate = 2.0;
      if (variant >= 3) o.null_kind = stillreach::NullMotionKind::MANIPULABILITY;
      if (variant == 2) o.null_kind = stillreach::NullMotionKind::POSTURE;
      if (variant == 4) o.rows = {0, 1, 2};
      if (variant == 5) {
        o.rows = {0, 2, 4};
        o.tool_axes = true;
      }
      const Chain chain = paper_chain();
      Robot robot(chain, law.settings, o);
      Controller made = controller_of(chain, law.settings, o);
      Controller door = std::move(made);  // what it points to moves along
      std::vector<double> q = Random(7 + variant).vector(11, 1.0), rates(11), target(16);
      Random random(3);
      for (int t = 0; t < 120; ++t) {
        const std::vector<double> twist = random.vector(6, 0.4);
        if (t == 40) CHECK(door.fail(3)), robot.fail(3);
        if (t == 60) CHECK(door.fail(5, stillreach::derated(0.3))), robot.fail(5, stillreach::Health::DERATED, 0.3);
        if (t == 80) CHECK(door.restore(3)), robot.restore(3);
        const bool tracks = t % 3 == 2;
        double frame[12];
        if (tracks) {
          const stillreach::Pose at = door.pose();
          std::copy_n(at.T, 16, target.data());
          target[3] += 0.01;
          CHECK(kernel().read_pose(target.data(), frame));
        }
        const std::int32_t status = tracks ? door.track(q, target, twist, rates) : door.step(q, twist, rates);
        CHECK(status == robot.tick(q.data(), twist.data(), tracks ? frame : nullptr));
        CHECK(std::equal(rates.begin(), rates.end(), robot.rates.begin()));
        CHECK(door.task_error() == robot.answer.task_error);
        CHECK(std::equal(robot.lower.begin(), robot.lower.end(), door.lower().data()));
        CHECK(door.health(5) == (t >= 60 ? stillreach::Health::DERATED : stillreach::Health::HEALTHY));
        for (int i = 0; i < 11; ++i) q[i] += o.period * rates[i];
      }
      ++laws;
    }
  CHECK(laws == 54);
}

void what_is_wrong_is_said() {
  const std::vector<Joint> good = joints_of(planar_chain(3), Options());
  CHECK(Arm::check(good).empty());
  const auto says = [&](auto spoil, const char* words) {
    std::vector<Joint> joints = good;
    spoil(joints);
    const std::string said = Arm::check(joints);
    CHECK(said.find(words) != std::string::npos);
    bool threw = false;
    try {
      Arm arm(joints);
    } catch (const std::invalid_argument& error) {
      threw = said == error.what();
    }
    CHECK(threw);
  };
  says([](auto& j) { j.clear(); }, "at least one joint");
  says([](auto& j) { j[1].axis[2] = 0.0; }, "joint 1 (j2): its axis");
  says([](auto& j) { j[1].placement.T[0] = 2.0; }, "joint 1 (j2): its placement");
  says([](auto& j) { j[2].velocity_limit = -1.0; }, "velocity limit");
  says([](auto& j) { j[2].velocity_limit = std::nan(""); }, "velocity limit");
  says([](auto& j) { j[0].lower = 2.0, j[0].upper = 1.0; }, "lower position limit");
  says([](auto& j) { j[0].acceleration_limit = -1.0; }, "acceleration limit");
  says([](auto& j) { j[2].name = "j1"; }, "another joint has that name");

  const Arm arm(good, tool_of(planar_chain(3)));
  CHECK(arm.n() == 3 && arm.index("j2") == 1 && arm.index("j9") == -1 && arm.joint(2).name == "j3");
  const auto refused = [&](auto spoil, const char* words) {
    stillreach::Options options;
    spoil(options);
    CHECK(Controller::check(arm, options).find(words) != std::string::npos);
  };
  refused([](auto& o) { o.rows = {}; }, "rows");
  refused([](auto& o) { o.rows = {1, 0}; }, "ascending");
  refused([](auto& o) { o.period = 0.0; }, "period");
  refused([](auto& o) { o.track_gain = std::nan(""); }, "track_gain");
  refused([](auto& o) { o.transition_rate = -1.0; }, "transition_rate");
  refused([](auto& o) { o.null_vector = {1.0}; }, "null_vector: 3 numbers");
  refused([](auto& o) { o.null_motion = stillreach::NullMotionKind::MANIPULABILITY; }, "null_largest");
  refused([](auto& o) { o.null_motion = stillreach::NullMotionKind::GRADIENT; }, "null_motion");
  refused([](auto& o) { o.null_failures = 9; }, "null_failures: 1 to 8");
}

// A joint at the base, one that follows it half as fast the other way round, a slide between them and the tool.
std::vector<Joint> coupled_joints() {
  std::vector<Joint> joints(3);
  for (int i = 0; i < 3; ++i) joints[i].name = std::string(1, "abc"[i]);
  joints[0].placement = stillreach::Pose(0, 0, 1);
  joints[1].placement = stillreach::Pose(2, 0, 0);
  joints[1].follows = "a";
  joints[1].multiplier = -0.5;
  joints[1].offset = 0.2;
  joints[2].placement = stillreach::Pose(1, 0, 0);
  joints[2].kind = stillreach::JointKind::PRISMATIC;
  joints[2].axis[0] = 2.0, joints[2].axis[2] = 0.0;
  return joints;
}

void joints_follow_others() {
  const Arm arm(coupled_joints(), stillreach::Pose(0, 3, 0));
  CHECK(arm.n() == 2 && arm.index("c") == 1 && arm.index("b") == -1 && arm.joint(1).name == "c");
  const double a = 0.7, slide = 0.4, b = 0.2 - 0.5 * a;
  const std::vector<double> q = {a, slide};
  stillreach::Pose tool;
  std::vector<double> jacobian(12), few(11);
  CHECK(arm.kinematics(q, tool, jacobian));
  const double x = 2 * std::cos(a) + (1 + slide) * std::cos(a + b) - 3 * std::sin(a + b);
  const double y = 2 * std::sin(a) + (1 + slide) * std::sin(a + b) + 3 * std::cos(a + b);
  CHECK(std::abs(tool.T[3] - x) < 1e-14 && std::abs(tool.T[7] - y) < 1e-14 && std::abs(tool.T[11] - 1) < 1e-14);
  CHECK(std::abs(tool.T[0] - std::cos(a + b)) < 1e-15 && std::abs(tool.T[4] - std::sin(a + b)) < 1e-15);
  const double by_a = -2 * std::sin(a) - 0.5 * ((1 + slide) * std::sin(a + b) + 3 * std::cos(a + b));
  const double expected[12] = {by_a,
                               2 * std::cos(a) + 0.5 * ((1 + slide) * std::cos(a + b) - 3 * std::sin(a + b)),
                               0,
                               0,
                               0,
                               0.5,
                               std::cos(a + b),
                               std::sin(a + b),
                               0,
                               0,
                               0,
                               0};
  for (int i = 0; i < 12; ++i) CHECK(std::abs(jacobian[i] - expected[i]) < 1e-14);
  stillreach::Pose again;
  CHECK(arm.kinematics(q, again) && std::equal(tool.T, tool.T + 16, again.T));
  CHECK(!arm.kinematics(q, again, few) && !arm.kinematics(few, again));

  stillreach::Options options;
  options.rows = {0, 1};
  Controller door(arm, options);
  const std::vector<double> twist = {0.03, -0.02, 0, 0, 0, 0};
  std::vector<double> rates(2);
  CHECK(door.step(q, twist, rates) == stillreach::OK);
  for (int r = 0; r < 2; ++r) CHECK(std::abs(jacobian[r] * rates[0] + jacobian[6 + r] * rates[1] - twist[r]) < 1e-14);

  const auto says = [](auto spoil, const char* words) {
    std::vector<Joint> joints = coupled_joints();
    spoil(joints);
    CHECK(Arm::check(joints).find(words) != std::string::npos);
  };
  says([](auto& j) { j[1].follows = "z"; }, "joint 1 (b): it follows z, which is no joint with a drive");
  says([](auto& j) { j[0].follows = "b"; }, "joint 0 (a): it follows b, which is no joint with a drive");
  says([](auto& j) { j[1].multiplier = std::nan(""); }, "joint 1 (b): its multiplier");
  says([](auto& j) { j[1].offset = HUGE_VAL; }, "joint 1 (b): its multiplier and offset");
}

void the_loop_takes_anything() {
  stillreach::Options options;
  options.rows = {0, 1};
  options.period = 0.01;
  Controller door(Arm(joints_of(planar_chain(3), Options()), tool_of(planar_chain(3))), options);
  static_assert(noexcept(door.step(std::declval<std::vector<double>&>(), std::declval<std::vector<double>&>(),
                                   std::declval<std::vector<double>&>())));
  std::vector<double> q = {0.3, 0.5, 0.2}, rates(3), few(2), none;
  const std::vector<double> twist = {0.1, 0.1, 0, 0, 0, 0};
  CHECK(door.step(q, twist, rates) == stillreach::OK);
  CHECK(door.step(q, twist, few) == stillreach::INVALID_INPUT && few[0] == 0.0 && few[1] == 0.0);
  CHECK(door.step(few, twist, rates) & stillreach::INVALID_INPUT);
  CHECK(door.step(q, none, rates) & stillreach::INVALID_INPUT);
  CHECK(door.track(q, few, twist, rates) & stillreach::INVALID_INPUT);
  for (double bad : {-0.01, kInfinity, std::nan("")})
    CHECK(door.step(q, twist, rates, bad) & stillreach::INVALID_INPUT);
  for (double bad : {std::nan(""), kInfinity}) {
    std::vector<double> spoiled = q;
    spoiled[1] = bad;
    CHECK(door.step(spoiled, twist, rates) & stillreach::INVALID_INPUT);
    for (double rate : rates) CHECK(std::isfinite(rate));
  }
  CHECK(!door.fail(-1) && !door.fail(3) && !door.fail(0, stillreach::derated(2.0)));
  CHECK(!door.fail(0, stillreach::runaway(std::nan(""))) && !door.fail(0, stillreach::confined(1.0, 0.0)));
  CHECK(!door.fail(0, {stillreach::Health::ONE_WAY, {0.5, 0.0}}));
  CHECK(door.health(0) == stillreach::Health::HEALTHY);
  CHECK(door.fail(0));
  door.step(q, twist, rates);
  CHECK(rates[0] == 0.0);
  CHECK(door.restore(0));
  const std::vector<double> slow = {0.02, 0.02, 0.02};
  CHECK(door.set_velocity_limits(slow) && !door.set_velocity_limits(few));
  door.step(q, twist, rates);
  for (double rate : rates) CHECK(std::abs(rate) <= 0.02);
  door.reset();
}

// One joint that turns about the task's axis, 0.35 rad before its position limit: with later periods that may be
// shorter, v period + v^2 / (2 a) = room, at 2 rad/s^2.
void periods_may_change_from_tick_to_tick() {
  Options o;
  o.rate = 9.0;
  o.position = 0.35;
  o.acceleration = 2.0;
  stillreach::Options options;
  options.rows = {5};
  Controller door(Arm(joints_of(planar_chain(1), o), tool_of(planar_chain(1))), options);
  const std::vector<double> q = {0.0}, twist = {0, 0, 0, 0, 0, 5}, moving = {1.0};
  std::vector<double> rates(1);
  for (const double period : {0.1, 0.05}) {
    door.reset(moving);
    CHECK(!(door.step(q, twist, rates, period) & stillreach::LIMIT_GIVEN_UP));
    const double most = 2.0 * (std::sqrt(period * period + 0.35) - period);
    CHECK_NEAR(rates[0], std::min(most, 1.0 + 2.0 * period), 1e-12);
  }
  CHECK(door.state().settings.period == options.period && door.state().settings.uneven == 0);
}

// Whoever needs more than the door shows reads the state, or owns it: limits that differ by direction, a speed below 1.
void the_memory_behind_the_door_is_open() {
  const Chain chain = planar_chain(3);
  Options o;
  o.rows = {0, 1};
  Robot robot(chain, law_settings(stillreach::LawKind::LEAST_ERROR), o);
  const std::vector<double> q = {0.3, 0.5, 0.2}, twist = {0.4, 0.3, 0, 0, 0, 0};
  robot.core.writable(robot.state.settings.rate_upper)[1] = 0.05;
  robot.core.limits_changed();
  robot.tick(q.data(), twist.data());
  CHECK(robot.lower[1] == -1.0 && robot.upper[1] == 0.05 && robot.rates[1] <= 0.05);
  const double whole = robot.answer.task_error;
  robot.state.settings.speed = 0.25;
  robot.tick(q.data(), twist.data());
  CHECK(robot.state.now.command[0] == 0.1 && robot.answer.task_error <= whole);

  const stillreach::ArmMemory copy = robot.arm;  // shares the links
  CHECK(copy.view().links == robot.arm.view().links && copy.n() == 3);
  stillreach::ControllerMemory here(robot.state.settings), there(std::move(here));
  for (int i = 0; i < 3; ++i) {
    there.writable(there.state.settings.rate_lower)[i] = -1.0;
    there.writable(there.state.settings.rate_upper)[i] = 1.0;
    there.writable(there.state.settings.position_lower)[i] = -kInfinity;
    there.writable(there.state.settings.position_upper)[i] = there.writable(there.state.settings.acceleration)[i] =
        kInfinity;
  }
  there.limits_changed();
  CHECK(there.state.settings.constant_bounds);
  there.tick(q.data(), twist.data());
  CHECK(there.answer.rates[0] != 0.0 && there.state.settings.rate_lower != robot.state.settings.rate_lower);
}

void a_loop_begins_on_an_arm_that_moves() {
  Options limited;
  limited.acceleration = 2.0;
  stillreach::Options options;
  options.rows = {0, 1};
  options.period = 0.01;
  Controller door(Arm(joints_of(planar_chain(3), limited), tool_of(planar_chain(3))), options);
  std::vector<double> q = {0.3, 0.5, 0.2}, rates(3), measured = {0.4, -0.2, 0.1};
  const std::vector<double> still(6, 0.0), few(2);
  CHECK(door.reset(measured));
  door.step(q, still, rates);
  for (int i = 0; i < 3; ++i) CHECK(std::abs(rates[i] - measured[i]) <= 2.0 * options.period + 1e-12);
  CHECK(std::abs(rates[0]) > 0.3);
  CHECK(!door.reset(few));
  measured[1] = std::nan("");
  CHECK(!door.reset(measured));
  door.reset();
  door.step(q, still, rates);
  for (double rate : rates) CHECK(std::abs(rate) <= 2.0 * options.period);
}

}  // namespace

int main() {
  the_same_bits_as_the_core();
  what_is_wrong_is_said();
  joints_follow_others();
  the_loop_takes_anything();
  a_loop_begins_on_an_arm_that_moves();
  periods_may_change_from_tick_to_tick();
  the_memory_behind_the_door_is_open();
  return finish("front door");
}
