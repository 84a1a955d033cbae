"""The forms of a fault in a scenario file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag

from stillreach.simulation.scenario_file.forms import Fraction, JointName, Moment, Number, Table, by_kind


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
    by_kind(FAULTS),
]
