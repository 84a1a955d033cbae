"""The forms of a motion in a scenario file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from stillreach.simulation.scenario_file.forms import (
    MOST_POINTS,
    Direction,
    Number,
    OrientationTable,
    Table,
    Text,
    Time,
    Times,
    Vector3,
    Vector6,
    by_kind,
)
from stillreach.simulation.scenario_file.robot_forms import FILE

Profile = Literal["constant", "trapezoidal", "minimum-jerk"]
Ramp = Annotated[float, Field(gt=0.0, le=0.5)]
PROFILE: Any = Field("constant", description="Speed along the way; the last two start and end at rest.")
RAMP: Any = Field(
    None, description="Part of the time in which trapezoidal speeds up, and slows down again; 0.25 if absent."
)
RELATIVE: Any = Field(False, description="Positions are shifts and orientations turns from the pose at the beginning.")


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
    axis: Direction = Field(description="Direction of the axis; the turn is right-handed about it.")
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


Attitudes = Annotated[list[KeepOrTurn], Field(max_length=MOST_POINTS)]
Points = Annotated[list[Vector3], Field(min_length=1, max_length=MOST_POINTS)]


class WaypointsMotion(Table):
    """From point to point on straight lines."""

    kind: Literal["waypoints"]
    points: Annotated[list[Vector3], Field(min_length=1, max_length=MOST_POINTS)] = Field(
        description="The points [length]."
    )
    orientations: Annotated[list[KeepOrTurn], Field(max_length=MOST_POINTS)] | None = Field(
        None, description='An attitude, or "keep", for each point.'
    )
    times: Times | None = Field(None, description="When each point is reached, since this motion began [s].")
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
    by_kind(MOTIONS),
]
