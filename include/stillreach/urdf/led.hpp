// The position of each joint of a chain: free, led by a free one, or fixed.
#pragma once

#include <functional>

#include "stillreach/urdf/joint.hpp"

STILLREACH_BEGIN
namespace urdf {

inline std::string of_joint(const std::string& name) { return "joint " + quoted(name); }

class Positions {
 public:
  // The leader of a joint of the file in `led`, or false for one that leads itself.
  using MimicOf = std::function<bool(const std::string& name, Led& led)>;

  // moving: the joints between base and tip that can move. fixed: positions of joints that are held.
  static std::map<std::string, Led> of(const std::vector<std::string>& moving, const MimicOf& mimic_of,
                                       const std::map<std::string, double>& fixed) {
    Positions all;
    all.own_.insert(moving.begin(), moving.end());
    for (const std::string& name : moving) all.follow(name, mimic_of);
    all.check_fixed(moving, fixed);
    for (const std::string& name : all.leaders_first_) all.place(name, fixed);
    std::map<std::string, Led> found;
    for (const std::string& name : moving) found[name] = checked(name, all.found_[name]);
    return found;
  }

 private:
  struct Mimic {
    bool follows = false;
    Led led;
  };

  void follow(std::string name, const MimicOf& mimic_of) {
    std::vector<std::string> walk;
    while (!mimics_.count(name)) {
      walk.push_back(name);
      Mimic mimic;
      mimic.follows = mimic_of(name, mimic.led);
      mimics_[name] = mimic;
      seen_.push_back(name);
      if (!mimic.follows) break;
      name = mimic.led.leader;
      if (std::find(walk.begin(), walk.end(), name) != walk.end())
        throw UrdfError("joints that follow each other in a cycle", "one that leads", 0, of_joint(name));
    }
    leaders_first_.insert(leaders_first_.end(), walk.rbegin(), walk.rend());
  }

  void check_fixed(const std::vector<std::string>& moving, const std::map<std::string, double>& fixed) const {
    std::vector<std::string> choices = moving;
    for (const std::string& name : seen_)
      if (!own_.count(name)) choices.push_back(name);
    for (const auto& [name, position] : fixed) {
      if (!mimics_.count(name))
        throw UrdfError(quoted(name), "a joint between base and tip: " + listed(choices), 0, "", "fixed");
      if (!std::isfinite(position))
        throw UrdfError(printed(position) + " for " + of_joint(name), "a finite number", 0, "", "fixed");
    }
  }

  void place(const std::string& name, const std::map<std::string, double>& fixed) {
    const Mimic& mimic = mimics_[name];
    const auto held = fixed.find(name);
    if (held != fixed.end()) {
      found_[name] = checked(name, {"", 0.0, held->second});
    } else if (!mimic.follows) {
      found_[name] = own_.count(name) ? Led{name, 1.0, 0.0} : Led{"", 0.0, 0.0};
    } else {
      const Led& leader = found_[mimic.led.leader];
      found_[name] = {leader.leader, mimic.led.factor * leader.factor,
                      mimic.led.factor * leader.offset + mimic.led.offset};
    }
  }

  static Led checked(const std::string& name, const Led& led) {
    const std::string limits = "between -" + printed(kLargest) + " and " + printed(kLargest);
    if (!(std::abs(led.offset) <= kLargest))
      throw UrdfError("the position " + printed(led.offset), "a joint " + limits, 0, of_joint(name));
    if (!(std::abs(led.factor) <= kLargest))
      throw UrdfError("a joint that makes " + printed(led.factor) + " times the motion of " + of_joint(led.leader),
                      "a factor " + limits, 0, of_joint(name));
    return led.factor != 0.0 ? led : Led{"", 0.0, led.offset};
  }

  std::set<std::string> own_;
  std::map<std::string, Mimic> mimics_;
  std::vector<std::string> seen_, leaders_first_;
  std::map<std::string, Led> found_;
};

}  // namespace urdf
STILLREACH_END
