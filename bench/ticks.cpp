// Control ticks and nothing else, for counting instructions: ticks LAW COUNT. The difference between two counts, divided
// by the number of ticks between them, is what one tick costs:
//   valgrind --tool=callgrind --callgrind-out-file=/dev/null ticks "least error" 1000
#include <cstdio>
#include <cstdlib>

#include "robot.hpp"

namespace {

// The paper's arm, joints 2, 4 and 7 failed, 50 deg/s, walking away from a random pose; the twist is out of reach.
double walk(const stillreach::LawSettings& law, long count) {
  Options o;
  o.rate = 50 * kDegree;
  Robot robot(paper_chain(), law, o);
  for (int joint : {1, 3, 6}) robot.fail(joint);
  Random random(1);
  std::vector<double> q = random.vector(robot.n, 2.0), twist = random.vector(6, 1.0);
  double sum = 0.0;
  for (long t = 0; t < count; ++t) {
    if (t % 50 == 0) q = random.vector(robot.n, 2.0), twist = random.vector(6, 1.0);
    robot.tick(q.data(), twist.data());
    for (int i = 0; i < robot.n; ++i) q[i] += 1e-3 * robot.rates[i], sum += robot.rates[i];
  }
  return sum;
}

}  // namespace

int main(int count, char** arguments) {
  if (count == 3)
    for (const NamedLaw& law : every_law())
      if (std::strcmp(law.name, arguments[1]) == 0) {
        std::printf("%s, %s: sum of rates %.17g\n", law.name, kernel().instruction_set, walk(law.settings, std::atol(arguments[2])));
        return 0;
      }
  std::fprintf(stderr, "usage: ticks LAW COUNT; laws:\n");
  for (const NamedLaw& law : every_law()) std::fprintf(stderr, "  %s\n", law.name);
  return 2;
}
