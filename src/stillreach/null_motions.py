"""Null motions: reference rates for the freedom that the task leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import NullMotionKind
from stillreach._door import FloatArray
from stillreach._forms import Number
from stillreach._kinds import Kind, key
from stillreach._labels import Labels
from stillreach._lists import PerJoint
from stillreach.errors import InputError

GAIN = key(Number("1/s", above=0.0), "Gain")
LARGEST = key(Number("arm/s", above=0.0), "Largest rate of any joint; all rates are scaled down together")


Core = tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]


@dataclass(frozen=True, kw_only=True, eq=False)
class NullMotion(Kind):
    """Base of all null motions.

    Args:
        max_rate: largest rate [rad/s, m/s] of any joint; all rates are scaled down together.
    """

    kind: ClassVar[NullMotionKind]
    """The kind in the core."""

    max_rate: float = field(default=float("inf"), metadata=LARGEST)

    def __post_init__(self) -> None:
        object.__setattr__(self, "max_rate", _door.positive("max_rate", self.max_rate, allow_inf=True))

    def core(self, joints: Labels) -> Core:
        """(kind, gain, vector, gradient) as the compiled core reads them."""
        raise TypeError(f"{type(self).__name__} is a base class; use one of the null motions")


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
        return self.kind, 1.0, _vector("rates", self.rates, joints), None


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
        return self.kind, _door.positive("gain", self.gain), _vector("q", self.q, joints), None


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
        return self.kind, _door.positive("gain", self.gain), None, None


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
    max_rate: float = field(default=1.0, metadata=LARGEST)

    def __post_init__(self) -> None:
        super().__post_init__()
        _door.positive("max_rate", self.max_rate)  # near a singularity the gradient is unbounded

    def core(self, joints: Labels) -> Core:
        """The gain."""
        return self.kind, _door.positive("gain", self.gain), None, None


@dataclass(frozen=True, kw_only=True, eq=False)
class Tolerance(Manipulability):
    """Towards postures that can afford to lose any one joint: rates gain · ∇ ln min r.

    r is the relative manipulability of a working joint: √det(J Jᵀ) without it over that with it. The gradient is
    analytic. Joints that are nearly as bad as the worst have a part, so that rates do not jump where the worst joint
    changes; those with r below 0.001, as the elbow of a spherical arm in a pose task, have none: no posture helps them.
    Where no joint is spare, it is zero.

    Args:
        gain: [rad²/s].
    """

    word = "tolerance"
    kind = NullMotionKind.TOLERANCE


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
            return self.kind, gain, None, self.gradient
        return self.kind, gain, _vector("gradient", self.gradient, joints), None


NULL_MOTIONS: tuple[type[NullMotion], ...] = (Manipulability, Tolerance, Centring, Posture, Rates, Gradient)
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
) -> tuple[NullMotionKind, float, float, npt.ArrayLike | None, Callable[..., object] | None]:
    """(kind, gain, largest rate, vector, gradient) of a null motion, as the compiled core reads them."""
    if motion is None:
        return NullMotionKind.NONE, 0.0, float("inf"), None, None
    kind, gain, vector, gradient = motion.core(joints)
    return kind, gain, motion.max_rate, vector, gradient


def _vector(name: str, value: Any, joints: Labels) -> FloatArray:
    return _door.vector(name, value, len(joints.names), labels=joints)
