"""The forms of laws and null motions in a scenario file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from stillreach.simulation.scenario_file.forms import NotNegative, Positive, Start, Table, by_kind, word_form

PRICED_ROWS = "position|orientation|[vw][xyz]"
BY_ROWS = Field(
    json_schema_extra={
        "minProperties": 1,
        "maxProperties": 3,
        "propertyNames": {"pattern": f"^({PRICED_ROWS})( +({PRICED_ROWS}))*$"},
    }
)
"""A table of prices in the JSON schema; when a file is loaded, the law checks its rows."""


def _price_form(value: Any) -> str:
    return word_form(value) if isinstance(value, str | int | float) else "<table>"


class LawTable(Table):
    """What laws have in common."""

    rank_tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        1e-10, description="Singular values below this, relative to the largest, count as zero."
    )


class LeastErrorLaw(LawTable):
    """The least task error inside the bounds: the default."""

    kind: Literal["least-error"]
    price: Annotated[
        Annotated[Positive, Tag("<number>")]
        | Annotated[Literal["none", "position-first"], Tag("<word>")]
        | Annotated[dict[str, Positive], BY_ROWS, Tag("<table>")],
        Discriminator(_price_form),
    ] = Field(
        80.0,
        description="What a task error costs: a number in units of the task's weights (1/m by default, whatever the "
        'units of the file), "position-first", prices by rows such as { position = 100, orientation = 8 }, or "none": '
        "the bare optimum.",
    )


class SingularityRobustLaw(LawTable):
    """The paper's damped inverse."""

    kind: Literal["singularity-robust"]
    damping: Annotated[
        Annotated[NotNegative, Tag("<number>")] | Annotated[Literal["exact", "closed-form"], Tag("<word>")],
        Discriminator(word_form),
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
    by_kind(LAWS),
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
    by_kind(NULL_MOTIONS),
]
