// Control ticks, and rows of batches, for counting instructions: `ticks KIND COUNT` does that many, all of them in
// piece(). bench/instructions.py counts what is inside:
//   valgrind --tool=callgrind --callgrind-out-file=/dev/null --collect-atstart=no --toggle-collect=piece ticks "least
//   error" 1000
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "robot.hpp"

// What is counted. A function of C, because callgrind is told its name.
extern "C" __attribute__((noinline)) void piece(const std::function<void()>& work) { work(); }

namespace {

using Work = std::function<double(long count)>;  // returns a sum of its results

// The paper's arm, joints 2, 4 and 7 failed, 50 deg/s, walking away from a random pose; the twist is out of reach.
Work walk(const stillreach::LawSettings& law) {
  return [law](long count) {
    Options o;
    o.rate = 50 * kDegree;
    Robot robot(paper_chain(), law, o);
    for (int joint : {1, 3, 6}) robot.fail(joint);
    Random random(1);
    std::vector<double> q = random.vector(robot.n, 2.0), twist = random.vector(6, 1.0);
    const std::function<void()> tick = [&] { robot.tick(q.data(), twist.data()); };
    double sum = 0.0;
    for (long t = 0; t < count; ++t) {
      if (t % 50 == 0) {
        q = random.vector(robot.n, 2.0);
        twist = random.vector(6, 1.0);
      }
      piece(tick);
      for (int i = 0; i < robot.n; ++i) {
        q[i] += 1e-3 * robot.rates[i];
        sum += robot.rates[i];
      }
    }
    return sum;
  };
}

// The same arm and faults, `count` rows of a batch at once: random poses, twists of which some are out of reach.
Work batch(const stillreach::LawSettings& law) {
  return [law](long count) {
    const Robot robot(paper_chain(), law);
    const int n = robot.n;
    Random random(1);
    const std::vector<double> q = random.vector(static_cast<int>(count) * n, 2.0),
                              twist = random.vector(static_cast<int>(count) * 6, 0.3);
    std::vector<double> lower(n, -50 * kDegree), upper(n, 50 * kDegree), rates(q.size());
    std::vector<std::int32_t> status(count);
    for (int joint : {1, 3, 6}) lower[joint] = upper[joint] = 0.0;
    stillreach::Batch b{};
    b.arm = robot.arm.view();
    b.law = law;
    b.m = 6;
    b.every_row = 1;
    for (int r = 0; r < 6; ++r) b.rows[r] = r;
    b.q = q.data();
    b.twist = twist.data();
    b.twist_stride = 6;
    b.lower = lower.data();
    b.upper = upper.data();
    b.rates = rates.data();
    b.status = status.data();
    struct alignas(64) Line {
      double numbers[8];
    };
    std::vector<Line> doubles(kernel().batch_doubles(n, false) / 8 + 1);
    std::vector<int> ints(kernel().batch_ints(n));
    std::vector<std::int8_t> bytes(kernel().batch_bytes(n));
    piece([&] { kernel().batch(b, 0, count, {doubles[0].numbers, ints.data(), bytes.data()}); });
    double sum = 0.0;
    for (double rate : rates) sum += rate;
    return sum;
  };
}

// Every kind of work by its name: what is new is counted once it has a line here and `make instructions` was run.
std::vector<std::pair<std::string, Work>> every_kind() {
  std::vector<std::pair<std::string, Work>> kinds;
  for (const NamedLaw& law : every_law()) kinds.emplace_back(law.name, walk(law.settings));
  for (const NamedLaw& law : every_law())
    for (const char* name : {"pseudoinverse", "exact", "least error", "keep direction"})
      if (std::strcmp(law.name, name) == 0) kinds.emplace_back("batch, " + std::string(name), batch(law.settings));
  return kinds;
}

std::string compiler() {
#if defined(__clang__)
  const char* const name = "Clang";
  const int version[] = {__clang_major__, __clang_minor__, __clang_patchlevel__};
#else
  const char* const name = "GCC";
  const int version[] = {__GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__};
#endif
  return name + (" " + std::to_string(version[0])) + "." + std::to_string(version[1]) + "." +
         std::to_string(version[2]);
}

}  // namespace

// Without arguments: the compiler, the instruction set and every kind, one a line.
int main(int count, char** arguments) {
  if (count == 3)
    for (const auto& [name, work] : every_kind())
      if (name == arguments[1]) {
        std::printf("%s, %s: sum of results %.17g\n", name.c_str(), kernel().instruction_set,
                    work(std::atol(arguments[2])));
        return 0;
      }
  if (count != 1) {
    std::fprintf(stderr, "usage: ticks KIND COUNT; ticks alone lists the kinds\n");
    return 2;
  }
  std::printf("%s\n%s\n", compiler().c_str(), kernel().instruction_set);
  for (const auto& kind : every_kind()) std::printf("%s\n", kind.first.c_str());
  return 0;
}
