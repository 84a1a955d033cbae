"""What a scenario file is made of: numbers in their ranges, one or several, tables without other keys."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

LARGEST = 1e9
LEAST_TIME = 1e-6
MOST_JOINTS = 200
MOST_PARTS = 200
MOST_POINTS = 2000

Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(gt=0.0, le=LARGEST)]
NotNegative = Annotated[float, Field(ge=0.0, le=LARGEST)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Time = Annotated[float, Field(ge=LEAST_TIME, le=LARGEST)]
Moment = Annotated[float, Field(ge=0.0, le=LARGEST)]
Limit = Annotated[float, Field(ge=0.0, allow_inf_nan=True)]
Bound = Annotated[float, Field(allow_inf_nan=True)]
Text = Annotated[str, Field(min_length=1, max_length=1000)]
JointName = Annotated[str, Field(min_length=1, max_length=200)]


Entry = TypeVar("Entry")
Each = Annotated[list[Entry], Field(min_length=1, max_length=MOST_JOINTS)]
"""One for each joint."""


def exactly(count: int) -> tuple[AfterValidator, FieldInfo]:
    """So many entries in a list: for the check, and for the JSON schema."""

    def check(entries: list[Any]) -> list[Any]:
        if len(entries) != count:
            raise PydanticCustomError("entries", "{count} entries", {"count": count})
        return entries

    return AfterValidator(check), Field(json_schema_extra={"minItems": count, "maxItems": count})


def _not_all_zero(entries: list[float]) -> list[float]:
    if not any(entries):
        raise PydanticCustomError("all_zero", "numbers that are not all 0")
    return entries


def _rising(times: list[float]) -> list[float]:
    if any(later <= earlier for earlier, later in pairwise(times)):
        raise PydanticCustomError("rising", "times that rise")
    return times


def _lower_first(bounds: list[float]) -> list[float]:
    if bounds[0] > bounds[1]:
        raise PydanticCustomError("interval", "the lower one first")
    return bounds


Vector3 = Annotated[list[Number], *exactly(3)]
Direction = Annotated[list[Number], *exactly(3), AfterValidator(_not_all_zero)]
Quaternion = Annotated[list[Number], *exactly(4), AfterValidator(_not_all_zero)]
Vector6 = Annotated[list[Number], *exactly(6)]
Mask = Annotated[list[bool], *exactly(6), AfterValidator(_not_all_zero)]
Interval = Annotated[list[Bound], *exactly(2), AfterValidator(_lower_first)]
Times = Annotated[list[Time], Field(min_length=1, max_length=MOST_POINTS), AfterValidator(_rising)]


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


def word_form(value: Any) -> str:
    """Which form of "a number or a word" a value has."""
    return "<word>" if isinstance(value, str) else "<number>"


Start = Annotated[
    Annotated[Each[Number], Tag("<each>")] | Annotated[dict[JointName, Number], Tag("<by joint>")],
    Discriminator(lambda value: "<by joint>" if isinstance(value, dict) else "<each>"),
]
Limits = Annotated[
    Annotated[Limit, Tag("<one>")]
    | Annotated[Each[Limit], Tag("<each>")]
    | Annotated[dict[JointName, Limit], Tag("<by joint>")],
    Discriminator(_form),
]
Intervals = Annotated[
    Annotated[Interval, Tag("<one>")]
    | Annotated[Each[Interval], Tag("<each>")]
    | Annotated[dict[JointName, Interval], Tag("<by joint>")],
    Discriminator(_interval_form),
]


class Table(BaseModel):
    """A table of the file: no other keys, no conversions, no NaN."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class UnitsTable(Table):
    """Units of the numbers in this file. Time is in seconds always."""

    length: Literal["m", "cm", "mm", "in", "ft"] = Field("m", description="Unit of lengths and positions.")
    angle: Literal["rad", "deg"] = Field("rad", description="Unit of angles.")


class OrientationTable(Table):
    """An attitude, in exactly one of these forms."""

    rotation_vector: Vector3 | None = Field(None, description="Axis times angle [angle].")
    quaternion: Quaternion | None = Field(None, description="w, x, y, z; any length but 0.")
    rpy: Vector3 | None = Field(
        None, description="Roll, pitch, yaw [angle] as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll)."
    )
    pitch_yaw_roll: Vector3 | None = Field(
        None, description="Pitch, yaw, roll [angle]: R = Ry(pitch) Rz(yaw) Rx(roll)."
    )

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if len(self.model_fields_set) != 1:
            forms = ", ".join(OrientationTable.model_fields)
            raise PydanticCustomError("orientation", "exactly one of {forms}", {"forms": forms})
        return self


def by_kind(tables: dict[str, type[Table]]) -> Discriminator:
    """Choose a table by its ``kind``."""

    def chosen(value: Any) -> str | None:
        kind = value.get("kind") if isinstance(value, dict) else None
        return f"<{kind}>" if isinstance(kind, str) and kind in tables else None

    return Discriminator(chosen)
