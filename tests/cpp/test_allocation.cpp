// A tick takes nothing from the heap, from the first one on.
#include "heap.hpp"

#include "check.hpp"
#include "robot.hpp"
#include "stillreach/stillreach.hpp"

namespace {

void* volatile sink = nullptr;  // volatile: the compiler may not leave out an allocation that goes there

long taken() { return heap_calls + new_calls; }

// The counter itself: planted allocations of every kind are seen.
void planted_allocations_are_seen() {
  const auto seen = [](auto plant) {
    const long before = taken();
    plant();
    return taken() > before;
  };
  CHECK(seen([] {
    sink = std::malloc(24);
    std::free(sink);
  }));
  CHECK(seen([] {
    sink = std::calloc(3, 8);
    std::free(sink);
  }));
  CHECK(seen([] {
    sink = std::malloc(8);
    sink = std::realloc(sink, 4000);
    std::free(sink);
  }));
  CHECK(seen([] {
    sink = std::aligned_alloc(32, 64);
    std::free(sink);
  }));
  CHECK(seen([] { sink = new double, delete static_cast<double*>(sink); }));
  CHECK(seen([] { sink = new double[7], delete[] static_cast<double*>(sink); }));
  struct alignas(64) Wide {
    double x[8];
  };
  CHECK(seen([] { sink = new Wide, delete static_cast<Wide*>(sink); }));
  CHECK(seen([] { sink = std::vector<double>(40).data(); }));
  CHECK(!seen([] { sink = nullptr; }));
}

// And it is seen from inside a tick's loop: 100 ticks, one of them with an allocation beside it.
void planted_allocation_in_a_loop_is_seen() {
  Robot robot(paper_chain(), law_settings(stillreach::LawKind::LEAST_ERROR));
  const std::vector<double> q = Random(1).vector(11, 1.0);
  const double twist[6] = {0.5, 0.1, 0.3, 0, 0, 0};
  const long before = taken();
  for (int t = 0; t < 100; ++t) {
    robot.tick(q.data(), twist);
    if (t == 57) sink = new double;
  }
  CHECK(taken() > before);
  delete static_cast<double*>(sink);
}

// One robot's life: commands in reach and far out of it, a NaN, joints that fail and come back. Returns what was taken
// from the heap between the first tick and the last.
long life(Robot& robot, int ticks, std::vector<double>& q, double* twist, const double* target) {
  Random random(7);
  const long before = taken();
  for (int t = 0; t < ticks; ++t) {
    const double speed = t % 5 == 4 ? 50.0 : t % 5 == 3 ? 1e-310 : 0.2;
    for (int r = 0; r < 6; ++r) twist[r] = random.between(-speed, speed);
    if (t % 7 == 2) robot.fail(random.below(robot.n));
    if (t % 7 == 4) robot.fail(random.below(robot.n), stillreach::Health::DERATED, 0.1);
    if (t % 7 == 5) robot.fail(random.below(robot.n), stillreach::Health::RUNAWAY, 0.05);
    if (t % 7 == 6) robot.restore(random.below(robot.n));
    if (t == ticks - 3)
      for (int i = 0; i < robot.n; ++i) robot.fail(i);
    if (t == ticks - 2)
      for (int i = 0; i < robot.n; ++i) robot.restore(i);
    const double good = q[0];
    if (t % 11 == 10) q[0] = std::nan("");
    robot.tick(q.data(), twist, t % 3 == 2 ? target : nullptr);
    q[0] = good;
    for (int i = 0; i < robot.n; ++i) q[i] += 0.01 * robot.rates[i];
  }
  return taken() - before;
}

void ticks_take_nothing() {
  const double target[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0.5, 0.5};
  double twist[6];
  for (const NamedLaw& law : every_law())
    for (int n : {3, 5, 6, 7, 11, 50, 500})
      for (int variant = 0; variant < 4; ++variant) {
        Options o;
        if (variant & 1) {
          o.rows = {0, 1, 2};
          o.position = 3.0;
          o.acceleration = 20.0;
        }
        if (variant & 2) {
          o.null_kind = stillreach::NullMotionKind::MANIPULABILITY;
          o.transition_rate = 2.0;
          o.joint_matrix = n <= 50;
        }
        Robot robot(n == 11 ? paper_chain() : skew_chain(n, n), law.settings, o);
        std::vector<double> q = Random(n).vector(n, 1.0);
        const long count = life(robot, n < 100 ? 60 : 15, q, twist, target);
        if (count) std::fprintf(stderr, "law '%s', n = %d, variant %d: %ld allocations\n", law.name, n, variant, count);
        CHECK(count == 0);
      }
}

void the_front_door_takes_nothing_after_it_opened() {
  stillreach::Joint joint;
  joint.velocity_limit = 1.0;
  joint.acceleration_limit = 50.0;
  std::vector<stillreach::Joint> joints(7, joint);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].placement = stillreach::Pose(0.0, 0.0, 0.3);
    joints[i].axis[i % 2] = 1.0;
    joints[i].axis[2] = 0.0;
  }
  stillreach::Controller door{stillreach::Arm(joints)};
  std::vector<double> q(7, 0.4), rates(7), twist(6, 0.1), limits(7, 0.5);
  const long before = taken();
  for (int t = 0; t < 60; ++t) {
    if (t == 20) door.fail(2);
    if (t == 40) door.restore(2);
    if (t == 50) door.set_velocity_limits(limits);
    const stillreach::Pose target = door.pose();
    if (t % 2 == 0) door.step(q, twist, rates);
    if (t % 2 == 1) door.track(q, target.T, twist, rates);
    for (std::size_t i = 0; i < 7; ++i) q[i] += 0.001 * rates[i];
  }
  door.reset();
  CHECK(taken() == before);
}

void rollouts_take_nothing() {
  const int n = 11, steps = 20;
  for (const NamedLaw& law : every_law()) {
    Robot robot(paper_chain(), law.settings);
    std::vector<double> q = Random(3).vector(n, 1.0), twists(6 * (2 * steps + 1), 0.3);
    std::vector<double> scratch(4 * n);
    std::vector<std::int8_t> scratch_active(n);
    std::vector<std::vector<double>> rows;
    stillreach::Record to{};
    stillreach::each_array(to, n, [&](auto*& array, const char*, int count) {
      rows.emplace_back(steps * count);
      array = reinterpret_cast<std::remove_reference_t<decltype(array)>>(rows.back().data());
    });
    const long before = taken();
    for (int stages : {1, 2})
      kernel().rollout(robot.state, q.data(), twists.data(), nullptr, steps, stages, true, nullptr,
                       robot.core.workspace.view(), robot.answer, scratch.data(), scratch_active.data(), to);
    CHECK(taken() == before);
  }
}

}  // namespace

int main() {
  planted_allocations_are_seen();
  planted_allocation_in_a_loop_is_seen();
  ticks_take_nothing();
  rollouts_take_nothing();
  the_front_door_takes_nothing_after_it_opened();
  return finish("allocation");
}
