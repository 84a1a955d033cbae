"""The form of a scenario file: which keys it may have, of which type, in which range, and what they mean.

This is what pydantic checks and what the JSON schema is made of. Units: [length] and [angle] are those that the file
declares; time is in seconds, and gains are in the units of the Python API.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

LARGEST = 1e9
LEAST_TIME = 1e-6
MOST_JOINTS = 500

Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Time = Annotated[float, Field(ge=LEAST_TIME, le=LARGEST)]
Moment = Annotated[float, Field(ge=0.0, le=LARGEST)]
Limit = Annotated[float, Field(ge=0.0, allow_inf_nan=True)]
Bound = Annotated[float, Field(allow_inf_nan=True)]
Vector3 = Annotated[list[Number], Field(min_length=3, max_length=3)]
Vector4 = Annotated[list[Number], Field(min_length=4, max_length=4)]
Vector6 = Annotated[list[Number], Field(min_length=6, max_length=6)]
Interval = Annotated[list[Bound], Field(min_length=2, max_length=2)]
Text = Annotated[str, Field(min_length=1, max_length=1000)]
JointName = Annotated[str, Field(min_length=1, max_length=200)]


def _form(value: Any) -> str:
    """Which form of "one for all, a list, or by joint name" a value has."""
    if isinstance(value, dict):
        return "<by joint>"
    return "<each>" if isinstance(value, list) else "<one>"


def _interval_form(value: Any) -> str:
    if isinstance(value, dict):
        return "<by joint>"
    nested = isinstance(value, list) and any(isinstance(entry, list) for entry in value)
    return "<each>" if nested else "<one>"


def _word_form(value: Any) -> str:
    return "<word>" if isinstance(value, str) else "<table>" if isinstance(value, dict) else "<number>"


def _rows_form(value: Any) -> str:
    return "<mask>" if isinstance(value, list) else "<word>"


def _weight_form(value: Any) -> str:
    nested = isinstance(value, list) and any(isinstance(entry, list) for entry in value)
    return "<matrix>" if nested else "<vector>"


Start = Annotated[
    Annotated[list[Number], Tag("<each>")] | Annotated[dict[JointName, Number], Tag("<by joint>")],
    Discriminator(lambda value: "<by joint>" if isinstance(value, dict) else "<each>"),
]
Limits = Annotated[
    Annotated[Limit, Tag("<one>")]
    | Annotated[list[Limit], Tag("<each>")]
    | Annotated[dict[JointName, Limit], Tag("<by joint>")],
    Discriminator(_form),
]
Intervals = Annotated[
    Annotated[Interval, Tag("<one>")]
    | Annotated[list[Interval], Tag("<each>")]
    | Annotated[dict[JointName, Interval], Tag("<by joint>")],
    Discriminator(_interval_form),
]
Weight = Annotated[
    Annotated[list[Positive], Tag("<vector>")] | Annotated[list[list[Number]], Tag("<matrix>")],
    Discriminator(_weight_form),
]


class Table(BaseModel):
    """A table of the file: no other keys, no conversions, no NaN."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class UnitsTable(Table):
    """Units of the numbers in this file. Time is in seconds always."""

    length: Literal["m", "cm", "mm", "inch", "foot"] = Field("m", description="Unit of lengths and positions.")
    angle: Literal["rad", "degree"] = Field("rad", description="Unit of angles.")


class OrientationTable(Table):
    """An attitude, in exactly one of these forms."""

    rotation_vector: Vector3 | None = Field(None, description="Axis times angle [angle].")
    quaternion: Vector4 | None = Field(None, description="w, x, y, z; any length but 0.")
    rpy: Vector3 | None = Field(
        None, description="Roll, pitch, yaw [angle] as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll)."
    )
    pitch_yaw_roll: Vector3 | None = Field(
        None, description="Pitch, yaw, roll [angle]: R = Ry(pitch) Rz(yaw) Rx(roll)."
    )


class ToolTable(Table):
    """The task's point and axes seen from the arm's tool."""

    position: Vector3 = Field([0.0, 0.0, 0.0], description="The point [length].")
    orientation: OrientationTable | None = Field(None, description="Its axes; those of the tool if absent.")


class BuiltInRobot(Table):
    """An arm that comes with stillreach."""

    arm: Text = Field(description="Name of a built-in arm: nasa_modular, canadarm2, planar, snake.")
    n: Annotated[int, Field(ge=1, le=MOST_JOINTS)] | None = Field(None, description="Number of joints (planar, snake).")
    lengths: Annotated[list[NotNegative], Field(min_length=1, max_length=MOST_JOINTS)] | None = Field(
        None, description="Lengths of the segments [length] (nasa_modular)."
    )


class ModuleRobot(Table):
    """An arm of roll and pitch modules, straight up along z at zero."""

    modules: Annotated[str, Field(min_length=1, max_length=MOST_JOINTS)] = Field(
        description="R (roll, about the link) and P (pitch, across it), from base to tool."
    )
    lengths: Annotated[list[NotNegative], Field(min_length=1, max_length=MOST_JOINTS)] = Field(
        description="Base to first pitch, pitch to pitch, last pitch to tool [length]: one more than pitches."
    )


class DHEntry(Table):
    """One row of a Denavit-Hartenberg table."""

    a: Number = Field(0.0, description="Link length, along x [length].")
    alpha: Number = Field(0.0, description="Link twist, about x [angle].")
    d: Number = Field(0.0, description="Link offset, along z [length].")
    theta: Number = Field(0.0, description="Joint angle, about z [angle].")
    kind: Literal["revolute", "prismatic"] = Field("revolute", description="What the joint is.")
    name: JointName | None = Field(None, description="The joint's name; j1, j2, ... if absent.")


class DHRobot(Table):
    """An arm from Denavit-Hartenberg rows."""

    dh: Annotated[list[DHEntry], Field(min_length=1, max_length=MOST_JOINTS)] = Field(
        description="One row for each joint, from the base on."
    )
    convention: Literal["standard", "modified"] = Field("standard", description="Of the rows; modified is Craig's.")


class FileRobot(Table):
    """What robots from files have in common."""

    tip: Text | None = Field(None, description="Link (URDF), body or site (MJCF) that carries the tool.")
    base: Text | None = Field(None, description="Link or body that the arm stands on; the root if absent.")
    fixed: dict[JointName, Number] = Field(
        {}, description="Joints that are held at a value [angle, or length for slides] and are no part of the arm."
    )


FILE = "relative to this file, or package:NAME/PATH for a file of an installed Python package."


class UrdfRobot(FileRobot):
    """A robot from a URDF file."""

    urdf: Text = Field(description=f"The file, {FILE}")


class MjcfRobot(FileRobot):
    """A robot from an MJCF file (MuJoCo)."""

    mjcf: Text = Field(description=f"The file, {FILE}")


ROBOTS = {"arm": BuiltInRobot, "modules": ModuleRobot, "dh": DHRobot, "urdf": UrdfRobot, "mjcf": MjcfRobot}
"""What a robot table can be, by the key that says so."""


def _robot_form(value: Any) -> str | None:
    keys = [key for key in ROBOTS if isinstance(value, dict) and key in value]
    return f"<{keys[0]} robot>" if keys else None


Robot = Annotated[
    Annotated[BuiltInRobot, Tag("<arm robot>")]
    | Annotated[ModuleRobot, Tag("<modules robot>")]
    | Annotated[DHRobot, Tag("<dh robot>")]
    | Annotated[UrdfRobot, Tag("<urdf robot>")]
    | Annotated[MjcfRobot, Tag("<mjcf robot>")],
    Discriminator(_robot_form),
]


class WeightsTable(Table):
    """What counts as 1 in task errors and joint rates, and how much each row and joint counts."""

    length: Positive | None = Field(None, description="What counts as 1 [length]; one metre if absent.")
    angle: Positive | None = Field(None, description="What counts as 1 [angle]; one radian if absent.")
    task: Weight | None = Field(None, description="Weights of the squared task error: 6, or 6 lists of 6.")
    joints: Weight | None = Field(None, description="Weights of the squared rates: one a joint, or a matrix.")


Rows = Annotated[
    Annotated[Literal["pose", "position", "orientation"], Tag("<word>")]
    | Annotated[Annotated[list[bool], Field(min_length=6, max_length=6)], Tag("<mask>")],
    Discriminator(_rows_form),
]


class TaskTable(Table):
    """Which part of the motion is the task, at which point."""

    rows: Rows = Field("pose", description="What is asked, or six true or false over vx, vy, vz, wx, wy, wz.")
    frame: Literal["base", "tool"] = Field("base", description="The axes that the rows are taken along.")
    tool: ToolTable | None = Field(None, description="The task's point; the arm's tool if absent.")
    weights: WeightsTable | None = Field(None, description="Units and weights of task errors and rates.")


def _kind(tables: dict[str, type[Table]]) -> Discriminator:
    """Choose a table by its ``kind``."""

    def chosen(value: Any) -> str | None:
        kind = value.get("kind") if isinstance(value, dict) else None
        return f"<{kind}>" if isinstance(kind, str) and kind in tables else None

    return Discriminator(chosen)


Profile = Literal["constant", "trapezoidal", "minimum-jerk"]
Ramp = Annotated[float, Field(gt=0.0, le=0.5)]
PROFILE = Field("constant", description="Speed along the way; the last two start and end at rest.")
RAMP = Field(None, description="Part of the time in which trapezoidal speeds up, and slows down again; 0.25 if absent.")
RELATIVE = Field(False, description="Positions are shifts and orientations turns from the pose at the beginning.")


class TwistMotion(Table):
    """A constant velocity of the tool."""

    kind: Literal["twist"]
    twist: Vector6 = Field(description="vx, vy, vz [length/s], wx, wy, wz [angle/s], along base axes.")
    duration: Time | None = Field(None, description="How long [s]; to the end if absent (the last motion only).")


class WaitMotion(Table):
    """The tool is to stay where it is."""

    kind: Literal["wait"]
    duration: Time = Field(description="How long [s].")


class LineMotion(Table):
    """Straight to a point, turning evenly to an attitude."""

    kind: Literal["line"]
    to: Vector3 | None = Field(None, description="The point [length]; stays there if absent.")
    orientation: OrientationTable | None = Field(None, description="The attitude at the end; kept if absent.")
    duration: Time = Field(description="How long [s].")
    profile: Profile = PROFILE
    ramp: Ramp | None = RAMP
    relative: bool = RELATIVE


class CircleMotion(Table):
    """Round an axis from wherever the tool is."""

    kind: Literal["circle"]
    centre: Vector3 = Field(description="A point on the axis [length].")
    axis: Vector3 = Field(description="Direction of the axis; the turn is right-handed about it.")
    angle: Number | None = Field(None, description="How far [angle]; once round if absent.")
    duration: Time = Field(description="How long [s].")
    attitude: Literal["keep", "follow"] = Field("keep", description="Whether the tool turns with the circle.")
    profile: Profile = PROFILE
    ramp: Ramp | None = RAMP
    relative: bool = Field(False, description="The centre is a shift from the point at the beginning.")


def _is_keep(value: Any) -> str:
    return "<word>" if isinstance(value, str) else "<table>"


KeepOrTurn = Annotated[
    Annotated[Literal["keep"], Tag("<word>")] | Annotated[OrientationTable, Tag("<table>")], Discriminator(_is_keep)
]


class WaypointsMotion(Table):
    """From point to point on straight lines."""

    kind: Literal["waypoints"]
    points: Annotated[list[Vector3], Field(min_length=1)] = Field(description="The points [length].")
    orientations: list[KeepOrTurn] | None = Field(None, description='An attitude, or "keep", for each point.')
    times: list[Time] | None = Field(None, description="When each point is reached, since this motion began [s].")
    duration: Time | None = Field(None, description="How long in all [s], in place of times.")
    profile: Profile = Field("constant", description="Speed on each leg; the last two stop at each point.")
    ramp: Ramp | None = RAMP
    relative: bool = RELATIVE


class TableMotion(Table):
    """Poses at given times, from a CSV file."""

    kind: Literal["pose-table"]
    file: Text = Field(description=f"A CSV file with columns time, x, y, z and an attitude or none, {FILE}")
    relative: bool = RELATIVE


MOTIONS: dict[str, type[Table]] = {
    "twist": TwistMotion,
    "wait": WaitMotion,
    "line": LineMotion,
    "circle": CircleMotion,
    "waypoints": WaypointsMotion,
    "pose-table": TableMotion,
}
MotionTable = Annotated[
    Annotated[TwistMotion, Tag("<twist>")]
    | Annotated[WaitMotion, Tag("<wait>")]
    | Annotated[LineMotion, Tag("<line>")]
    | Annotated[CircleMotion, Tag("<circle>")]
    | Annotated[WaypointsMotion, Tag("<waypoints>")]
    | Annotated[TableMotion, Tag("<pose-table>")],
    _kind(MOTIONS),
]


class LawTable(Table):
    """What laws have in common."""

    rank_tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        1e-10, description="Singular values below this, relative to the largest, count as zero."
    )


class LeastErrorLaw(LawTable):
    """The least task error inside the bounds: the default."""

    kind: Literal["least-error"]
    max_gain: Annotated[
        Annotated[Positive, Tag("<number>")] | Annotated[Literal["none"], Tag("<word>")], Discriminator(_word_form)
    ] = Field(10.0, description='Largest joint rate over twist, in weighted units; "none": the bare optimum.')


class SingularityRobustLaw(LawTable):
    """The paper's damped inverse."""

    kind: Literal["singularity-robust"]
    damping: Annotated[
        Annotated[NotNegative, Tag("<number>")] | Annotated[Literal["exact", "closed-form"], Tag("<word>")],
        Discriminator(_word_form),
    ] = Field("exact", description="How the damping is found, or the damping itself in weighted units.")
    norm: Literal["inf", "2"] = Field("inf", description="Norm of the rates that is limited.")


class KeepDirectionLaw(LawTable):
    """Slower, but never off course."""

    kind: Literal["keep-direction"]


class PseudoinverseLaw(LawTable):
    """The paper's baseline; honours no limits."""

    kind: Literal["pseudoinverse"]


LAWS: dict[str, type[Table]] = {
    "least-error": LeastErrorLaw,
    "singularity-robust": SingularityRobustLaw,
    "keep-direction": KeepDirectionLaw,
    "pseudoinverse": PseudoinverseLaw,
}
LawChoice = Annotated[
    Annotated[LeastErrorLaw, Tag("<least-error>")]
    | Annotated[SingularityRobustLaw, Tag("<singularity-robust>")]
    | Annotated[KeepDirectionLaw, Tag("<keep-direction>")]
    | Annotated[PseudoinverseLaw, Tag("<pseudoinverse>")],
    _kind(LAWS),
]


class NullMotionTable(Table):
    """What null motions have in common."""

    max_rate: Positive | None = Field(
        None, description="Largest rate asked of any joint [angle/s; length/s for an arm of slides]; none if absent."
    )


GAIN = Field(1.0, description="Gain [1/s].")


class ManipulabilityMotion(NullMotionTable):
    """Away from singularities."""

    kind: Literal["manipulability"]
    gain: Positive = Field(1.0, description="Gain [rad²/s].")


class CentringMotion(NullMotionTable):
    """Towards the middle of the position limits."""

    kind: Literal["centring"]
    gain: Positive = GAIN


class PostureMotion(NullMotionTable):
    """Towards a posture."""

    kind: Literal["posture"]
    q: Start = Field(description="Joint values [angle, or length for slides], all or by name (0 for the others).")
    gain: Positive = GAIN


class RatesMotion(NullMotionTable):
    """Near given rates."""

    kind: Literal["rates"]
    rates: Start = Field(
        description="Joint rates [angle/s, or length/s for slides], all or by name (0 for the others)."
    )


NULL_MOTIONS: dict[str, type[Table]] = {
    "manipulability": ManipulabilityMotion,
    "centring": CentringMotion,
    "posture": PostureMotion,
    "rates": RatesMotion,
}
NullMotionChoice = Annotated[
    Annotated[ManipulabilityMotion, Tag("<manipulability>")]
    | Annotated[CentringMotion, Tag("<centring>")]
    | Annotated[PostureMotion, Tag("<posture>")]
    | Annotated[RatesMotion, Tag("<rates>")],
    _kind(NULL_MOTIONS),
]


class FaultTable(Table):
    """What all faults have."""

    joint: JointName = Field(description="Name of the joint.")
    at: Moment = Field(0.0, description="Onset [s].")
    until: Moment | None = Field(None, description="When the joint works again [s]; never if absent.")


class LockedFault(FaultTable):
    """The joint stands where it is."""

    kind: Literal["locked"]


class DeratedFault(FaultTable):
    """The joint moves at most at a fraction of its rate limit."""

    kind: Literal["derated"]
    fraction: Fraction = Field(description="What is left of the rate limit, 0 to 1.")


class RunawayFault(FaultTable):
    """The joint moves at a rate that nobody commands."""

    kind: Literal["runaway"]
    rate: Number = Field(description="The rate [angle/s, or length/s for a slide].")


FAULTS: dict[str, type[Table]] = {"locked": LockedFault, "derated": DeratedFault, "runaway": RunawayFault}
FaultChoice = Annotated[
    Annotated[LockedFault, Tag("<locked>")]
    | Annotated[DeratedFault, Tag("<derated>")]
    | Annotated[RunawayFault, Tag("<runaway>")],
    _kind(FAULTS),
]


class ScenarioTable(Table):
    """A scenario: which arm starts where, what it is told, what breaks and when."""

    name: Annotated[str, Field(max_length=200)] = Field("", description="Title of plots and files.")
    description: Annotated[str, Field(max_length=10_000)] = Field("", description="What it shows, for readers.")
    units: UnitsTable = Field(UnitsTable(length="m", angle="rad"), description="Units of this file.")
    robot: Robot = Field(description="The arm.")
    start: Start = Field(
        description="Joint values at time 0 [angle, or length for slides]: all, or by name (others 0)."
    )
    motion: Annotated[list[MotionTable], Field(min_length=1)] = Field(description="What the tool is to do, in order.")
    faults: list[FaultChoice] = Field([], description="What fails when.")
    law: LawChoice = Field(LeastErrorLaw(kind="least-error"), description="How the rates are found.")
    task: TaskTable | None = Field(None, description="Which part of the motion is the task; the whole pose if absent.")
    null_motion: NullMotionChoice | None = Field(None, description="What the freedom that is left is used for.")
    period: Time = Field(0.01, description="Time between ticks [s].")
    duration: Time | None = Field(None, description="How long in all [s]; as long as the motion if absent.")
    integrator: Literal["euler", "rk4"] = Field("euler", description="How the arm is moved from tick to tick.")
    loop: Literal["open", "closed"] = Field("open", description="Whether the tool's pose is fed back.")
    gain: NotNegative | None = Field(None, description="Gain of the feedback [1/s]; 2 if absent.")
    track_limits: Annotated[list[Limit], Field(min_length=2, max_length=2)] | None = Field(
        None, description="Largest correction [length/s, angle/s]; none if absent."
    )
    rate_limits: Limits | None = Field(None, description="In place of the arm's own [angle/s, or length/s for slides].")
    position_limits: Intervals | None = Field(None, description="Lower and upper, in place of the arm's own.")
    acceleration_limits: Limits | None = Field(None, description="In place of the arm's own [angle/s², length/s²].")
    return_rate: NotNegative = Field(0.0, description="At which joints outside their limits are asked back [angle/s].")
    transition_rate: NotNegative = Field(2.0, description="How fast the null motion takes over after a fault [1/s].")


CHOICES: dict[str, dict[str, type[Table]]] = {
    "motion": MOTIONS,
    "faults": FAULTS,
    "law": LAWS,
    "null_motion": NULL_MOTIONS,
}
"""The kinds of each table that has a kind, by its key."""
