// Reads chains from standard input (tip, base, held joints, text; each field behind its length) and writes a line for
// each: the chain with a pose and a Jacobian, or why it is refused. tests/unit/arm/test_urdf_cpp.py compares them.
#include <cstdio>
#include <iostream>

#include "stillreach/urdf.hpp"

namespace {

bool read(std::string& field) {
  std::size_t length = 0;
  if (!(std::cin >> length)) return false;
  std::cin.get();
  field.resize(length);
  std::cin.read(&field[0], static_cast<std::streamsize>(length));
  return true;
}

void write(const std::string& text) { std::printf("%s\x1f", text.c_str()); }
void write(const double* numbers, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) std::printf("%.17g ", numbers[i]);
  std::printf("\x1f");
}

void write(const stillreach::UrdfChain& chain) {
  write("chain");
  write(chain.name);
  const stillreach::Arm arm(chain.joints, chain.tool);
  std::vector<double> q, jacobian(6 * static_cast<std::size_t>(arm.n()));
  for (int i = 0; i < arm.n(); ++i) q.push_back(0.3 * (i % 5) - 0.5);
  stillreach::Pose tool;
  if (!arm.kinematics(q, tool, jacobian)) std::abort();
  write(tool.T, 16);
  write(jacobian.data(), jacobian.size());
  for (const stillreach::Joint& joint : chain.joints) {
    write(joint.name);
    write(joint.follows);
    write(joint.kind == stillreach::JointKind::PRISMATIC ? "prismatic" : "revolute");
    write(joint.placement.T, 16);
    write(joint.axis, 3);
    const double numbers[] = {joint.lower,      joint.upper, joint.velocity_limit, joint.acceleration_limit,
                              joint.multiplier, joint.offset};
    write(numbers, 6);
  }
}

}  // namespace

int main() {
  std::string tip, base, count, name, position, text;
  while (read(tip) && read(base) && read(count)) {
    std::map<std::string, double> held;
    for (int i = 0; i < std::stoi(count) && read(name) && read(position); ++i) held[name] = std::stod(position);
    if (!read(text)) return 1;
    try {
      write(stillreach::read_urdf(text, tip, base, held));
    } catch (const stillreach::UrdfError& error) {
      write("refused");
      write(error.argument);
      write(std::to_string(error.line));
      write(error.element);
      write(error.got);
      write(error.expected);
      stillreach::UrdfChain chain;
      if (stillreach::check_urdf(chain, text, tip, base, held) != error.what()) return 2;
    }
    std::printf("\n");
  }
}
