// A planar arm of three unit links at (0, 90, 0) degrees, its second joint locked: v = (0.1, 0.2) m/s asks for the
// rates 0.2 and -0.5 rad/s of the others. The columns are (-2, 1), (-2, 0) and (-1, 0).
#include <cmath>
#include <cstdio>
#include <vector>

#include "stillreach/dispatch.hpp"

int main() {
  const double jacobian[6] = {-2, 1, -2, 0, -1, 0}, twist[2] = {0.1, 0.2};
  const double lower[3] = {-1, 0, -1}, upper[3] = {1, 0, 1}, expected[3] = {0.2, 0.0, -0.5};
  stillreach::LawSettings law{};
  law.rank_tolerance = 1e-10;
  double rates[3], residual[2];
  std::int8_t active[3] = {0, 0, 0};
  stillreach::Answer answer{};
  answer.rates = rates;
  answer.residual = residual;
  answer.active = active;

  const stillreach::Kernel& core = stillreach::kernel();
  std::vector<double> doubles(core.workspace_doubles(3, false));
  std::vector<int> ints(core.workspace_ints(3));
  std::vector<std::int8_t> bytes(core.workspace_bytes(3));
  core.solve(law, {2, 3, jacobian, twist, lower, upper, nullptr, {}}, {doubles.data(), ints.data(), bytes.data()},
             answer);
  std::printf("%s: %.4f %.4f %.4f rad/s\n", core.instruction_set, rates[0], rates[1], rates[2]);
  for (int i = 0; i < 3; ++i)
    if (!(std::fabs(rates[i] - expected[i]) < 1e-12)) return 1;
  return 0;
}
