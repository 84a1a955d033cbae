"""Null motions: reference rates for the freedom that the task leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import comb
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import NullMotionKind
from stillreach._door import FloatArray
from stillreach._forms import INF, Integer, Number
from stillreach._kinds import Kind, key
from stillreach._labels import Labels
from stillreach._lists import PerJoint
from stillreach.errors import InputError

GAIN = key(Number("1/s", above=0.0), "Gain")
LARGEST = "Largest rate of any joint; all rates are scaled down together"


MOST_FAILURES, MOST_CHOICES = 8, 5000
"""Joints of one set, and sets or facets, that a tick looks at; as in the core."""


class Core(NamedTuple):
    """A null motion as the compiled core reads it."""

    kind: NullMotionKind
    gain: float
    vector: npt.ArrayLike | None = None
    gradient: Callable[..., object] | None = None
    failures: int = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class NullMotion(Kind):
    """Base of all null motions.

    Args:
        max_rate: largest rate [rad/s, m/s] of any joint; all rates are scaled down together.
    """

    kind: ClassVar[NullMotionKind]
    """The kind in the core."""

    max_rate: float = field(default=INF, metadata=key(Number("arm/s", above=0.0, most=INF), LARGEST))

    def __post_init__(self) -> None:
        self.check_numbers()

    def core(self, joints: Labels) -> Core:
        """As the compiled core reads it."""
        raise TypeError(f"{type(self).__name__} is a base class; use one of the null motions")

    def check(self, n: int, m: int) -> None:
        """InputError where the null motion does not suit an arm of n joints and a task of m rows."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Rates(NullMotion):
    """Given reference rates (the paper's ν).

    Args:
        rates: (n,) [rad/s, m/s].
    """

    word = "rates"
    kind = NullMotionKind.RATES

    rates: npt.ArrayLike = field(
        metadata=key(PerJoint(Number("joint/s")), "Joint rates, all or by name, 0 for the others")
    )

    def core(self, joints: Labels) -> Core:
        """The given rates."""
        return Core(self.kind, 1.0, _vector("rates", self.rates, joints))


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture(NullMotion):
    """Towards a posture: rates gain · (q_posture - q).

    Unlimited revolute joints take the shortest turn.

    Args:
        q: (n,) [rad, m], or by joint name.
        gain: [1/s].
    """

    word = "posture"
    kind = NullMotionKind.POSTURE

    q: npt.ArrayLike = field(metadata=key(PerJoint(Number("joint")), "Joint values, all or by name, 0 for the others"))
    gain: float = field(default=1.0, metadata=GAIN)

    def core(self, joints: Labels) -> Core:
        """The posture and its gain."""
        return Core(self.kind, self.gain, _vector("q", self.q, joints))


@dataclass(frozen=True, kw_only=True, eq=False)
class Centring(NullMotion):
    """Towards the middle of the position limits; joints without two limits get rate 0.

    Args:
        gain: [1/s].
    """

    word = "centring"
    kind = NullMotionKind.CENTRING

    gain: float = field(default=1.0, metadata=GAIN)

    def core(self, joints: Labels) -> Core:
        """The gain."""
        return Core(self.kind, self.gain)


@dataclass(frozen=True, kw_only=True, eq=False)
class Manipulability(NullMotion):
    """Away from singularities: rates gain · ∇ ln √det(J Jᵀ) of the working joints' task Jacobian (Yoshikawa, 1985).

    The gradient is analytic. Where it is exactly zero by symmetry (e.g. a planar arm that could leave its plane), a
    push of 1 % of ``max_rate``, the same in every run, moves the arm away.

    Args:
        gain: [rad²/s].
    """

    word = "manipulability"
    kind = NullMotionKind.MANIPULABILITY

    gain: float = field(default=1.0, metadata=key(Number("rad²/s", above=0.0), "Gain"))
    max_rate: float = field(default=1.0, metadata=key(Number("arm/s", above=0.0), LARGEST))  # the gradient has no bound

    def core(self, joints: Labels) -> Core:
        """The gain."""
        return Core(self.kind, self.gain)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tolerance(Manipulability):
    """Towards postures that can afford to lose any one joint, or several: rates gain · ∇ ln min r.

    r is the relative manipulability without a set of joints: √det(J Jᵀ) without them over that with them. The gradient
    is analytic. Sets that are nearly as bad as the worst have a part, so that rates do not jump where the worst set
    changes; those with r below 0.001, as the elbow of a spherical arm in a pose task, have none: no posture helps them.
    Where fewer joints are spare, sets of as many as are spare count; where none is, the gradient is zero.

    Args:
        gain: [rad²/s].
        failures: how many joints are lost at once, 1 to 8; at most 5000 sets.
    """

    word = "tolerance"
    kind = NullMotionKind.TOLERANCE

    failures: int = field(default=1, metadata=key(Integer(1, MOST_FAILURES), "Joints that are lost at once, 1 to 8"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.failures > MOST_FAILURES:
            raise InputError("failures", f"{self.failures}", f"1 to {MOST_FAILURES}")

    def core(self, joints: Labels) -> Core:
        """Gain and number of failures."""
        return super().core(joints)._replace(failures=self.failures)

    def check(self, n: int, m: int) -> None:
        """InputError for too many sets."""
        if comb(n, self.failures) > MOST_CHOICES:
            text = f"{self.failures} of {n} joints, which is {comb(n, self.failures):,} sets"
            raise InputError("failures", text, f"at most {MOST_CHOICES:,} sets")


@dataclass(frozen=True, kw_only=True, eq=False)
class GuaranteedSpeed(Manipulability):
    """Towards postures that are fast without any one joint: rates gain · ∇ ln min s.

    s is the guaranteed speed after the loss of a working joint: what the tool reaches in every direction with the
    rates of the others, as in ``tolerance.report``. The gradient is analytic, and smooth as that of ``Tolerance``.
    Joints without which less than 0.001 of the speed is left have no part. Where no joint is spare, it is zero.

    Args:
        gain: [rad²/s].
    """

    word = "guaranteed-speed"
    kind = NullMotionKind.GUARANTEED_SPEED

    def check(self, n: int, m: int) -> None:
        """InputError for more facets than a tick looks at: of more than 16 joints in 6 directions."""
        if comb(n, m - 1) > MOST_CHOICES:
            text = f"GuaranteedSpeed for {n} joints and {m} rows"
            raise InputError("null_motion", text, "at most 16 joints for a pose, or Tolerance")


@dataclass(frozen=True, kw_only=True, eq=False)
class Gradient(NullMotion):
    """Along a given gradient: rates gain · gradient.

    Args:
        gradient: (n,), or a callable q (n,) -> (n,) that is evaluated once a tick. If a callable fails or returns an
            invalid value inside a running loop, the null motion is off for that tick (INVALID_INPUT).
            KeyboardInterrupt and SystemExit are raised.
        gain: rates per unit of the gradient.
    """

    word = "gradient"
    kind = NullMotionKind.GRADIENT
    in_files = False

    gradient: npt.ArrayLike | Callable[[npt.NDArray[np.float64]], npt.ArrayLike]
    gain: float = 1.0

    def core(self, joints: Labels) -> Core:
        """The gradient and its gain."""
        gain = _door.positive("gain", self.gain)
        if callable(self.gradient):
            return Core(self.kind, gain, None, self.gradient)
        return Core(self.kind, gain, _vector("gradient", self.gradient, joints))


NULL_MOTIONS: tuple[type[NullMotion], ...] = (
    Manipulability,
    Tolerance,
    GuaranteedSpeed,
    Centring,
    Posture,
    Rates,
    Gradient,
)
"""Every null motion."""


def checked_null_motion(value: Any, joints: Labels) -> NullMotion | None:
    """A null motion or None; bare rates become Rates. Raises InputError for other values."""
    if value is None or isinstance(value, NullMotion):
        return value
    try:
        return Rates(rates=_vector("null_motion", value, joints))
    except InputError:
        choices = f"{', '.join(kind.__name__ for kind in NULL_MOTIONS)}, {len(joints.names)} rates or None"
        raise InputError("null_motion", _door.describe(value), choices) from None


def null_motion_settings(
    motion: NullMotion | None, joints: Labels
) -> tuple[NullMotionKind, float, float, npt.ArrayLike | None, Callable[..., object] | None, int]:
    """(kind, gain, largest rate, vector, gradient, failures) of a null motion, as the compiled core reads them."""
    core = Core(NullMotionKind.NONE, 0.0) if motion is None else motion.core(joints)
    largest = float("inf") if motion is None else motion.max_rate
    return core.kind, core.gain, largest, core.vector, core.gradient, core.failures


def _vector(name: str, value: Any, joints: Labels) -> FloatArray:
    return _door.vector(name, value, len(joints.names), labels=joints)
