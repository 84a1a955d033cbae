// Arms from URDF texts, as Arm.from_urdf of the Python package makes them. Needs tinyxml2, which nothing else includes.
// Documents are taken as hostile: no entities, and bounds on size, depth and numbers.
#pragma once

#include "stillreach/stillreach.hpp"
#include "stillreach/urdf/chain.hpp"

STILLREACH_BEGIN
#if defined(STILLREACH_DISPATCH)
inline namespace dispatched {
#endif

/// A link between base and tip: behind the first `joints` of the chain, and where in the frame that the last of them
/// moves.
struct UrdfLink {
  std::string name;
  std::size_t joints;
  Pose frame;
};

/// What a text gives of a chain: the arguments of an Arm, the robot's name, and the links from base to tip.
struct UrdfChain {
  std::vector<Joint> joints;  ///< also those that follow others
  Pose tool;
  std::string name;
  std::vector<UrdfLink> links;
};

namespace front {

inline Pose pose_of(const urdf::Transform& from) {
  Pose to;
  std::copy_n(from.T, 16, to.T);
  return to;
}

inline Joint joint_of(const urdf::Moving& from) {
  Joint joint;
  joint.placement = pose_of(from.step.transform);
  std::copy(from.step.axis.begin(), from.step.axis.end(), joint.axis);
  joint.kind = from.step.kind;
  joint.name = from.step.name;
  if (from.drives()) {
    joint.velocity_limit = from.step.velocity;
    joint.lower = from.step.lower;
    joint.upper = from.step.upper;
    joint.acceleration_limit = from.step.acceleration;
  } else {
    joint.follows = from.led.leader;
    joint.multiplier = from.led.factor;
    joint.offset = from.led.offset;
  }
  return joint;
}

}  // namespace front

/// The chain from `base` ("": the root) to `tip` ("": the only end of the tree); joints in `fixed` are held at those
/// positions. Throws UrdfError, a std::invalid_argument, with line, element, what came and what was expected.
inline UrdfChain read_urdf(const std::string& text, const std::string& tip = {}, const std::string& base = {},
                           const std::map<std::string, double>& fixed = {}) {
  const urdf::Chain read = urdf::ChainReader(text).read(tip, base, fixed);
  UrdfChain chain;
  for (const urdf::Moving& joint : read.joints) chain.joints.push_back(front::joint_of(joint));
  chain.tool = front::pose_of(read.tool);
  chain.name = read.name;
  for (const urdf::Passed& link : read.links)
    chain.links.push_back({link.name, link.joints, front::pose_of(link.frame)});
  return chain;
}

/// The same without exceptions: what is wrong, or nothing, and then `chain` is it.
inline std::string check_urdf(UrdfChain& chain, const std::string& text, const std::string& tip = {},
                              const std::string& base = {}, const std::map<std::string, double>& fixed = {}) {
  try {
    chain = read_urdf(text, tip, base, fixed);
  } catch (const UrdfError& error) {
    return error.what();
  }
  return Arm::check(chain.joints, chain.tool);
}

inline Arm arm_from_urdf(const std::string& text, const std::string& tip = {}, const std::string& base = {},
                         const std::map<std::string, double>& fixed = {}) {
  const UrdfChain chain = read_urdf(text, tip, base, fixed);
  return Arm(chain.joints, chain.tool);
}

#if defined(STILLREACH_DISPATCH)
}  // namespace dispatched
#endif
STILLREACH_END
