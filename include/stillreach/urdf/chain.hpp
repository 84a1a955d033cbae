// The chain between two links of a URDF text: joints that move, with what lies between them, and the links on its way.
#pragma once

#include <tuple>

#include "stillreach/urdf/led.hpp"

STILLREACH_BEGIN
namespace urdf {

constexpr std::size_t kMaxPassed = 2000, kMaxMoving = 1000;

// A joint that moves: its step's transform is its frame in the one that the joint before moves.
struct Moving {
  Step step;
  Led led;  // by its own name where it has a drive
  bool drives() const { return led.leader == step.name; }
};

// A link on the way: behind so many of the joints that move, and where in the frame that the last one moves.
struct Passed {
  std::string name;
  std::size_t joints;
  Transform frame;
};

struct Chain {
  std::string name;
  std::vector<Moving> joints;
  Transform tool;
  std::vector<Passed> links;
};

class ChainReader {
 public:
  explicit ChainReader(const std::string& text) : robot_(Elements::of(text)), tree_(*robot_) {}

  // base: "" for the root. tip: "" for the only end of the tree.
  Chain read(std::string tip, std::string base, const std::map<std::string, double>& fixed) {
    if (base.empty()) base = tree_.root();
    check_link("base", base);
    if (tip.empty()) tip = only_end(base);
    check_link("tip", tip);
    const auto path = path_between(base, tip);
    if (path.size() > kMaxPassed)
      throw UrdfError(std::to_string(path.size()) + " joints between base and tip",
                      "at most " + std::to_string(kMaxPassed));
    Chain chain;
    chain.name = robot_->word("name").empty() ? "arm" : robot_->word("name");
    chain.links.push_back({base, 0, {}});
    assemble(steps_along(path), fixed, chain);
    limit_leaders(chain);
    return chain;
  }

 private:
  void check_link(const char* argument, const std::string& link) const {
    if (!tree_.has_link(link))
      throw UrdfError(quoted(link), "a link of the file: " + listed(tree_.links()), 0, "", argument);
  }

  std::string only_end(const std::string& base) const {
    const std::vector<std::string> ends = tree_.leaves(base);
    if (ends.size() == 1) return ends[0];
    throw UrdfError("no tip",
                    "a link's name, because the tree has " + std::to_string(ends.size()) + " ends: " + listed(ends), 0,
                    "", "tip");
  }

  // Links whose joints to their parents form the chain; true where it goes up to the parent.
  std::vector<std::pair<std::string, bool>> path_between(const std::string& base, const std::string& tip) const {
    std::vector<std::string> up = below_root(base), down = below_root(tip);
    while (!up.empty() && !down.empty() && up.back() == down.back()) {
      up.pop_back();
      down.pop_back();
    }
    std::vector<std::pair<std::string, bool>> path;
    for (const std::string& link : up) path.emplace_back(link, true);
    for (auto link = down.rbegin(); link != down.rend(); ++link) path.emplace_back(*link, false);
    return path;
  }
  std::vector<std::string> below_root(std::string link) const {
    std::vector<std::string> links;
    while (const auto* above = tree_.above(link)) {
      links.push_back(link);
      link = above->second;
    }
    return links;
  }

  std::vector<Step> steps_along(const std::vector<std::pair<std::string, bool>>& path) {
    std::vector<Step> steps;
    for (const auto& [link, up] : path) {
      std::vector<Step> own = steps_of(link, up);
      if (up) {
        std::reverse(own.begin(), own.end());
        for (Step& step : own) {
          step.transform = inverse(step.transform);
          for (double& a : step.axis) a = -a;
        }
      }
      own.back().link = up ? tree_.above(link)->second : link;
      steps.insert(steps.end(), own.begin(), own.end());
    }
    return steps;
  }

  std::vector<Step> steps_of(const std::string& link, bool up) {
    const Element& joint = *tree_.above(link)->first;
    if (joint.word("type") == "floating") {
      const std::string argument = up ? "tip" : "base";
      throw UrdfError(
          "the type 'floating' between base and tip",
          "a chain on one side of it: " + argument + "=" + quoted(link) + (up ? " ends before it" : " begins after it"),
          joint.line, joint.label(), argument);
    }
    const std::string name = joint.word("name");
    const std::vector<Step>& steps = read_joint(name).steps;
    for (const Step& step : steps)
      if (step.moves && step.name != name && tree_.joint(step.name))
        joint.refuse("a planar joint whose part " + quoted(step.name) + " has the name of another joint",
                     "unique names");
    return steps;
  }

  const ReadJoint& read_joint(const std::string& name) {
    const auto known = read_.find(name);
    if (known != read_.end()) return known->second;
    return read_[name] = JointReader(*tree_.joint(name), tree_.version()).read();
  }

  bool mimic_of(const std::string& name, Led& led) {
    const Element* joint = tree_.joint(name);
    if (!joint) return false;  // a part of a planar joint
    const ReadJoint& read = read_joint(name);
    if (!read.follows) return false;
    led = read.led;
    if (!tree_.joint(led.leader))
      joint->refuse(quoted(led.leader), "a joint to follow: " + listed(tree_.joint_names()));
    if (read_joint(led.leader).steps.size() > 2)
      joint->refuse("a joint that follows the planar joint " + quoted(led.leader),
                    "a leader with one degree of freedom");
    return true;
  }

  void assemble(const std::vector<Step>& steps, const std::map<std::string, double>& fixed, Chain& chain) {
    std::vector<std::string> moving;
    for (const Step& step : steps)
      if (step.moves) moving.push_back(step.name);
    const auto positions =
        Positions::of(moving, [this](const std::string& name, Led& led) { return mimic_of(name, led); }, fixed);
    Transform since;
    std::set<std::string> names;
    bool drives = false;
    for (const Step& step : steps) {
      if (!step.moves) {
        since = since * step.transform;
      } else {
        const Led& led = positions.at(step.name);
        if (led.leader.empty()) {
          since = since * moved(step.kind, step.axis, led.offset);
        } else {
          const std::string label = of_joint(step.name);
          if (!names.insert(step.name).second)
            throw UrdfError("a second joint of that name between base and tip", "unique names", 0, label);
          Moving joint{step, led};
          joint.step.transform = placed(since, label);
          since = Transform();
          drives = drives || joint.drives();
          chain.joints.push_back(joint);
        }
      }
      if (!step.link.empty()) chain.links.push_back({step.link, chain.joints.size(), made_rigid(since)});
    }
    if (!drives) throw UrdfError("no joint that moves between base and tip", "at least one", 0, "", "tip");
    if (names.size() > kMaxMoving)
      throw UrdfError(std::to_string(names.size()) + " moving joints between base and tip",
                      "at most " + std::to_string(kMaxMoving));
    chain.tool = placed(since, "the tool");
  }

  static Transform placed(const Transform& since, const std::string& whose) {
    const double far = std::fmax(std::abs(since(0, 3)), std::fmax(std::abs(since(1, 3)), std::abs(since(2, 3))));
    if (!(far <= kLargest))
      throw UrdfError("a position " + printed(far, "%.9g") + " m from the previous moving joint or the base",
                      "at most " + printed(kLargest) + " m along each axis", 0, whose);
    return made_rigid(since);
  }

  // Joints stay within their own limits and those of their followers; a follower's range that would leave no motion is
  // ignored, because such ranges are often copied.
  static void limit_leaders(Chain& chain) {
    std::map<std::string, Step*> leaders;
    std::map<std::string, std::pair<double, double>> own;
    for (Moving& joint : chain.joints)
      if (joint.drives()) {
        leaders[joint.step.name] = &joint.step;
        own[joint.step.name] = {joint.step.lower, joint.step.upper};
      }
    for (const Moving& joint : chain.joints) {
      if (joint.drives()) continue;
      Step& leader = *leaders.at(joint.led.leader);
      const double a = (joint.step.lower - joint.led.offset) / joint.led.factor;
      const double b = (joint.step.upper - joint.led.offset) / joint.led.factor;
      const double low = std::fmin(a, b), high = std::fmax(a, b);
      const auto& [lower, upper] = own[joint.led.leader];
      if (std::fmax(lower, low) < std::fmin(upper, high)) {
        leader.lower = std::fmax(leader.lower, low);
        leader.upper = std::fmin(leader.upper, high);
      }
      leader.velocity = std::fmin(leader.velocity, joint.step.velocity / std::abs(joint.led.factor));
      leader.acceleration = std::fmin(leader.acceleration, joint.step.acceleration / std::abs(joint.led.factor));
    }
    for (auto& [name, leader] : leaders)
      if (!(leader->lower < leader->upper)) std::tie(leader->lower, leader->upper) = own[name];
  }

  std::unique_ptr<Element> robot_;
  Tree tree_;
  std::map<std::string, ReadJoint> read_;
};

}  // namespace urdf
STILLREACH_END
