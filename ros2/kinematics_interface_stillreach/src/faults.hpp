// Faults of joints as parameters of a node name them.
#pragma once

#include <string>
#include <vector>

#include "stillreach/types.hpp"

namespace kinematics_interface_stillreach {

// The fault of each of the arm's joints, `all` by name. Throws std::invalid_argument with what is wrong.
// joints: names. kinds: of the first of them, the others are locked: "locked", "derated 0.3", "runaway 0.1", "confined
// -1 0.5", "one-way -1", "free-swinging"; numbers in SI units.
std::vector<stillreach::Fault> read_faults(const std::vector<std::string>& all, const std::vector<std::string>& joints,
                                           const std::vector<std::string>& kinds);

}  // namespace kinematics_interface_stillreach
