// One joint of a URDF text with checked numbers, as steps from its parent link to its child link.
#pragma once

#include <algorithm>

#include "stillreach/urdf/rigid.hpp"
#include "stillreach/urdf/tree.hpp"

STILLREACH_BEGIN
namespace urdf {

constexpr double kLargest = 1e6;  // of a placement [m, rad] or position: beyond it rounding errors are too large
constexpr double kNoLimitFrom = 1e9;

// Follows a joint, at factor times its position plus offset; without a leader it stands at the offset.
struct Led {
  std::string leader;
  double factor = 1.0, offset = 0.0;
};

// A transform, or a joint that can move.
struct Step {
  bool moves = false;
  Transform transform = {};
  std::string name = {};
  JointKind kind = JointKind::REVOLUTE;
  Vector axis = {0, 0, 1};
  double lower = -HUGE_VAL, upper = HUGE_VAL, velocity = HUGE_VAL, acceleration = HUGE_VAL;
  std::string link = {};  // that the chain reaches with this step, or empty
};

struct ReadJoint {
  std::vector<Step> steps;
  bool follows = false;
  Led led = {};
};

class JointReader {
 public:
  JointReader(const Element& joint, Version version)
      : joint_(joint),
        limit_(joint.child("limit")),
        quaternions_(version >= Version{1, 1}),
        strict_(version >= Version{1, 2}) {}

  ReadJoint read() const {
    static const std::vector<std::string> types = {"revolute", "continuous", "prismatic", "fixed", "planar"};
    const std::string kind = joint_.word("type");
    if (std::find(types.begin(), types.end(), kind) == types.end())
      joint_.refuse(quoted(kind), "a type of joint: " + listed(types));
    for (const auto& one : joint_.children)
      if (one->tag.compare(0, 6, "xacro:") == 0) one->refuse("xacro", xacro_advice());
    ReadJoint read;
    read.steps.emplace_back();
    read.steps[0].transform = origin(joint_.child("origin"));
    if (kind == "fixed") return read;
    const Element& mimic = joint_.child("mimic");
    if (!mimic.missing) {
      read.follows = true;
      read.led = leader(mimic);
    }
    Step step;
    step.moves = true;
    step.name = joint_.word("name");
    step.axis = axis(joint_.child("axis"));
    if (kind == "planar") {
      if (read.follows) mimic.refuse("a planar joint that follows another", "a planar joint without <mimic>");
      rates(step, false);
      add_planar(step, read.steps);
      return read;
    }
    step.kind = kind == "prismatic" ? JointKind::PRISMATIC : JointKind::REVOLUTE;
    if (kind != "continuous") position(step, kind, read.follows);
    rates(step, read.follows);
    read.steps.push_back(step);
    return read;
  }

 private:
  static Vector vector_of(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

  Transform origin(const Element& at) const {
    const Transform place = shifted(at.has("xyz") ? vector_of(at.numbers("xyz", 3, kLargest)) : Vector{0, 0, 0});
    if (at.has("quat_xyzw")) {
      if (quaternions_) {
        if (at.has("rpy")) at.refuse("both rpy and quat_xyzw", "only one of them");
        const std::vector<double> q = at.numbers("quat_xyzw", 4);
        if (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0)
          at.refuse("a quaternion of length 0", "quat_xyzw='0 0 0 1' for no turn");
        return place * turned_by_quaternion({q[0], q[1], q[2], q[3]});
      }
      if (!at.has("rpy")) at.refuse("quat_xyzw in a file of URDF 1.0", "rpy, or <robot version=\"1.1\">");
    }
    if (!at.has("rpy")) return place;
    const std::vector<double> angles = at.numbers("rpy", 3, kLargest);
    return place * turned_by_angles(angles[0], angles[1], angles[2]);
  }

  static Vector axis(const Element& at) {
    if (at.missing) return {1, 0, 0};
    const Vector xyz = vector_of(at.numbers("xyz", 3));
    if (xyz[0] == 0 && xyz[1] == 0 && xyz[2] == 0) at.refuse("an axis of length 0", "a direction, e.g. xyz='0 0 1'");
    return unit(xyz);
  }

  static Led leader(const Element& mimic) {
    Led led;
    led.leader = mimic.word("joint");
    if (led.leader.empty()) mimic.refuse("a missing joint name", "<mimic joint=\"...\"/>");
    led.factor = mimic.number("multiplier", 1.0, kLargest);
    led.offset = mimic.number("offset", 0.0, kLargest);
    return led;
  }

  // URDF cannot write infinity: numbers that large mean no limit.
  double limit(const char* name, double otherwise) const {
    const double number = limit_.number(name, otherwise);
    return std::abs(number) >= kNoLimitFrom ? std::copysign(HUGE_VAL, number) : number;
  }

  // The range; an invalid one of a follower is ignored.
  void position(Step& step, const std::string& kind, bool follows) const {
    if (limit_.missing && (strict_ || !follows))
      joint_.refuse("no <limit> in a " + kind + " joint",
                    "<limit lower=\"...\" upper=\"...\" velocity=\"...\"/> (a joint without limits is of type "
                    "continuous)");
    for (const char* name : {"lower", "upper"})
      if (strict_ && !limit_.has(name))
        limit_.refuse(std::string("no ") + name + " in a " + kind + " joint",
                      "lower and upper, which URDF 1.2 requires");
    const double lower = limit("lower", 0.0), upper = limit("upper", 0.0);
    const bool wrong = lower > upper || lower == HUGE_VAL || upper == -HUGE_VAL;
    if (wrong && (strict_ || !follows))
      limit_.refuse("lower " + printed(lower) + " above upper " + printed(upper), "lower at most upper");
    if (wrong) return;
    step.lower = lower;
    step.upper = upper;
  }

  // Largest velocity and acceleration; those of a follower are ignored unless above 0.
  void rates(Step& step, bool follows) const {
    const char* const names[] = {"velocity", "acceleration", "deceleration"};
    double limits[] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    for (int k = 0; k < (strict_ ? 3 : 1); ++k) {
      limits[k] = limit(names[k], HUGE_VAL);
      if (limits[k] < 0.0 && !follows)
        limit_.refuse(std::string("the ") + names[k] + " limit " + printed(limits[k]), "a number of at least 0");
      if (limits[k] <= 0.0 && follows) limits[k] = HUGE_VAL;
    }
    step.velocity = limits[0];
    step.acceleration = std::fmin(limits[1], limits[2]);
  }

  // Two slides across the axis and a turn about it, named as MuJoCo names them; URDF has no ranges for them.
  static void add_planar(const Step& turn, std::vector<Step>& steps) {
    Step first = turn, second = turn, last = turn;
    first.kind = second.kind = JointKind::PRISMATIC;
    across(turn.axis, first.axis, second.axis);
    first.name += "_TX";
    second.name += "_TY";
    last.name += "_RZ";
    steps.insert(steps.end(), {first, second, last});
  }

  const Element& joint_;
  const Element& limit_;
  bool quaternions_, strict_;
};

}  // namespace urdf
STILLREACH_END
