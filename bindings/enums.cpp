// The core's closed sets as Python enumerations, from its own lists of names.
#include "settings.hpp"

#define STILLREACH_VALUE(name, meaning) .value(#name, Set::name, meaning)
#define STILLREACH_ENUM(Kind, LIST, doc)                                       \
  {                                                                            \
    using Set = stillreach::Kind;                                              \
    nb::enum_<Set>(m, #Kind, nb::is_arithmetic(), doc) LIST(STILLREACH_VALUE); \
  }

void bind_enums(nb::module_& m) {
  STILLREACH_ENUM(
      Reason, STILLREACH_REASON,
      "Why a rate bound is what it is. In ``Solution.active`` negative at the lower bound, positive at the upper one.")
  STILLREACH_ENUM(Health, STILLREACH_HEALTH, "State of a joint, as ``Run.health`` and ``Controller.health`` hold it.")
  STILLREACH_ENUM(JointKind, STILLREACH_JOINT_KIND, "What a joint does.")
  STILLREACH_ENUM(LawKind, STILLREACH_LAW_KIND, "The laws.")
  STILLREACH_ENUM(DampingKind, STILLREACH_DAMPING_KIND, "Where the damping of SingularityRobust comes from.")
  STILLREACH_ENUM(NormKind, STILLREACH_NORM_KIND, "The size that its damping limits.")
  STILLREACH_ENUM(NullMotionKind, STILLREACH_NULL_MOTION_KIND, "The null motions.")
  nb::dict status;
#define STILLREACH_FLAG(name, value) status[#name] = value;
  STILLREACH_STATUS(STILLREACH_FLAG)
#undef STILLREACH_FLAG
  m.attr("STATUS") = status;
  m.attr("CLOSING_RATE") = static_cast<int>(stillreach::CLOSING_RATE);
  m.attr("CLOSING_POSITION") = static_cast<int>(stillreach::CLOSING_POSITION);
}
