#include "faults.hpp"

#include <algorithm>
#include <locale>
#include <sstream>
#include <stdexcept>

#include "stillreach/stillreach.hpp"

namespace kinematics_interface_stillreach {

namespace {

using stillreach::Fault;

[[noreturn]] void refuse(const std::string& text) {
  std::string forms;
  for (const stillreach::FaultForm& form : stillreach::kFaultForms)
    forms += (forms.empty() ? "" : ", ") + std::string(form.example);
  throw std::invalid_argument("failed_kinds: got '" + text + "', expected one of " + forms);
}

Fault read_fault(const std::string& text) {
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  std::string word;
  words >> word;
  for (const stillreach::FaultForm& form : stillreach::kFaultForms) {
    if (word != form.word) continue;
    Fault fault;
    fault.health = form.health;
    for (int k = 0; k < form.numbers; ++k)
      if (!(words >> fault.number[k])) refuse(text);
    if (words >> word || !stillreach::possible(fault)) refuse(text);
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
        i < kinds.size() ? read_fault(kinds[i]) : stillreach::locked();
  }
  return faults;
}

}  // namespace kinematics_interface_stillreach
