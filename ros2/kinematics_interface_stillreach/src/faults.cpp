#include "faults.hpp"

#include <algorithm>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace kinematics_interface_stillreach {

namespace {

using stillreach::Fault;
using stillreach::Health;

struct Kind {
  const char* word;
  Health health;
  std::size_t numbers;
};
const Kind kKinds[] = {{"locked", Health::LOCKED, 0},   {"derated", Health::DERATED, 1},
                       {"runaway", Health::RUNAWAY, 1}, {"confined", Health::CONFINED, 2},
                       {"one-way", Health::ONE_WAY, 1}, {"free-swinging", Health::FREE_SWINGING, 0}};

[[noreturn]] void refuse(const std::string& text) {
  throw std::invalid_argument("failed_kinds: got '" + text +
                              "', expected locked, 'derated SHARE' (0 to 1), 'runaway RATE', 'confined LOWER UPPER', "
                              "'one-way 1' or 'one-way -1', or free-swinging");
}

Fault read_fault(const std::string& text) {
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  std::string word;
  words >> word;
  for (const Kind& kind : kKinds) {
    if (word != kind.word) continue;
    Fault fault;
    fault.health = kind.health;
    for (std::size_t k = 0; k < kind.numbers; ++k)
      if (!(words >> fault.number[k])) refuse(text);
    const double a = fault.number[0], b = fault.number[1];
    if (words >> word) refuse(text);
    if (kind.health == Health::DERATED && !(a >= 0.0 && a <= 1.0)) refuse(text);
    if (kind.health == Health::CONFINED && !(a <= b)) refuse(text);
    if (kind.health == Health::ONE_WAY && a != 1.0 && a != -1.0) refuse(text);
    return fault;
  }
  refuse(text);
}

}  // namespace

std::vector<Fault> read_faults(const std::vector<std::string>& all, const std::vector<std::string>& joints,
                               const std::vector<std::string>& kinds) {
  std::vector<Fault> faults(all.size());
  if (kinds.size() > joints.size())
    throw std::invalid_argument("failed_kinds: got " + std::to_string(kinds.size()) +
                                ", expected at most one for each of the " + std::to_string(joints.size()) +
                                " failed_joints");
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto joint = std::find(all.begin(), all.end(), joints[i]);
    if (joint == all.end()) {
      std::string names;
      for (const std::string& name : all) names += (names.empty() ? "" : ", ") + name;
      throw std::invalid_argument("failed_joints: got '" + joints[i] + "', expected joints of the chain: " + names);
    }
    faults[static_cast<std::size_t>(joint - all.begin())] =
        i < kinds.size() ? read_fault(kinds[i]) : Fault{Health::LOCKED, {0.0, 0.0}};
  }
  return faults;
}

}  // namespace kinematics_interface_stillreach
