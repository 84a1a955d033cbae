"""The forms of the task in a scenario file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from stillreach.simulation.scenario_file.forms import (
    Each,
    Mask,
    NotNegative,
    Number,
    OrientationTable,
    Positive,
    Table,
    Vector3,
)


def _rows_form(value: Any) -> str:
    return "<mask>" if isinstance(value, list) else "<word>"


def _weight_form(value: Any) -> str:
    nested = isinstance(value, list) and any(isinstance(entry, list) for entry in value)
    return "<matrix>" if nested else "<vector>"


def _square(rows: list[list[float]]) -> list[list[float]]:
    if any(len(row) != len(rows) for row in rows):
        raise PydanticCustomError("square", "a square matrix, a list for each row")
    return rows


Weight = Annotated[
    Annotated[Each[NotNegative], Tag("<vector>")]
    | Annotated[Annotated[Each[Each[Number]], AfterValidator(_square)], Tag("<matrix>")],
    Discriminator(_weight_form),
]


class ToolTable(Table):
    """The task's point and axes seen from the arm's tool."""

    position: Vector3 = Field([0.0, 0.0, 0.0], description="The point [length].")
    orientation: OrientationTable | None = Field(None, description="Its axes; those of the tool if absent.")


class WeightsTable(Table):
    """What counts as 1 in task errors and joint rates, and how much each row and joint counts."""

    length: Positive | None = Field(None, description="What counts as 1 [length]; one metre if absent.")
    angle: Positive | None = Field(None, description="What counts as 1 [angle]; one radian if absent.")
    task: Weight | None = Field(None, description="Weights of the squared task error: 6, or 6 lists of 6.")
    joints: Weight | None = Field(None, description="Weights of the squared rates: one a joint, or a matrix.")


Rows = Annotated[
    Annotated[Literal["pose", "position", "orientation"], Tag("<word>")] | Annotated[Mask, Tag("<mask>")],
    Discriminator(_rows_form),
]


class TaskTable(Table):
    """Which part of the motion is the task, at which point."""

    rows: Rows = Field("pose", description="What is asked, or six true or false over vx, vy, vz, wx, wy, wz.")
    frame: Literal["base", "tool"] = Field("base", description="The axes that the rows are taken along.")
    tool: ToolTable | None = Field(None, description="The task's point; the arm's tool if absent.")
    weights: WeightsTable | None = Field(None, description="Units and weights of task errors and rates.")
