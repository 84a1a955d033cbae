"""The forms of an arm in a scenario file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, JsonValue, Tag

from stillreach import arms
from stillreach.simulation.scenario_file.forms import MOST_JOINTS, JointName, NotNegative, Number, Table, Text

NAMES: list[JsonValue] = [{"enum": [*sorted(arms.BUILDERS)]}, {"pattern": f"^({'|'.join(arms.SIZED)})[0-9]{{1,4}}$"}]
"""What arms are called, as a JSON schema."""


class BuiltInRobot(Table):
    """An arm that comes with stillreach."""

    arm: Text = Field(description="Its name, e.g. panda or planar3.", json_schema_extra={"anyOf": NAMES})
    n: Annotated[int, Field(ge=1, le=MOST_JOINTS)] | None = Field(
        None, description="Number of joints of planar and snake, where it is not part of the name."
    )
    tip: Text | None = Field(None, description="Link that carries the tool (robots by name); the flange if absent.")
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


ROBOTS: dict[str, type[Table]] = {
    "arm": BuiltInRobot,
    "modules": ModuleRobot,
    "dh": DHRobot,
    "urdf": UrdfRobot,
    "mjcf": MjcfRobot,
}
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
