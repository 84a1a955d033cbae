"""Plants: what an arm makes of the rates that it is told, in a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from stillreach import _door
from stillreach._core import SimulatedPlant
from stillreach._forms import Integer, Number
from stillreach._kinds import Kind, key

__all__ = ["KinematicPlant", "Plant"]

MOST_DEAD_TICKS = 10_000


class Plant(Kind):
    """Base of the plants."""


@dataclass(frozen=True, kw_only=True)
class KinematicPlant(Plant):
    """An arm without inertia. By default its joints have the rates that they are told and the positions it measures.

    Its joints have their true faults from the onset on, whether or not the controller knows of them.

    Args:
        lag: [s] time constant of the drives (first order); 0: none.
        dead_time: [s] until a rate arrives at the drives, in whole ticks (the nearest number); 0: none.
        resolution: [rad, m] of the encoders; 0: exact.
        noise: [rad, m] standard deviation of the encoders (normal, independent); 0: none.
        seed: of the noise.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "kinematic"

    lag: float = field(default=0.0, metadata=key(Number("s", least=0.0), "Time constant of the drives"))
    dead_time: float = field(default=0.0, metadata=key(Number("s", least=0.0), "Time until a rate arrives"))
    resolution: float = field(default=0.0, metadata=key(Number("arm", least=0.0), "Resolution of the encoders"))
    noise: float = field(default=0.0, metadata=key(Number("arm", least=0.0), "Standard deviation of the encoders"))
    seed: int = field(default=0, metadata=key(Integer(0, 2**32 - 1), "Seed of the noise"))

    def __post_init__(self) -> None:
        for name in ("lag", "dead_time", "resolution", "noise"):
            object.__setattr__(self, name, _door.positive(name, getattr(self, name), or_zero=True))
        object.__setattr__(self, "seed", _door.count("seed", self.seed, minimum=0))

    @property
    def exact(self) -> bool:
        """Whether joints do what they are told and positions are measured exactly, faults aside."""
        return not (self.lag or self.dead_time or self.resolution or self.noise)

    def simulated(self, n: int, period: float) -> SimulatedPlant:
        """Its state for n joints and ticks of a period [s]."""
        follow = -math.expm1(-period / self.lag) if self.lag else 1.0
        return SimulatedPlant(n, follow=follow, dead=round(self.dead_time / period), resolution=self.resolution)


PLANTS: tuple[type[Plant], ...] = (KinematicPlant,)
"""Every plant."""
