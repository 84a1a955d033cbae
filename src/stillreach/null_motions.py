"""What to do with the freedom that the task leaves: reference rates that the law stays near."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import NullMotionKind
from stillreach._door import FloatArray
from stillreach._labels import Labels
from stillreach.errors import InputError


@dataclass(frozen=True, kw_only=True, eq=False)
class NullMotion:
    """Base of all null motions.

    Args:
        max_rate: largest rate [rad/s, m/s] that is asked of any joint; all are scaled down together.
    """

    max_rate: float = float("inf")

    def __post_init__(self) -> None:
        object.__setattr__(self, "max_rate", _door.positive("max_rate", self.max_rate, allow_inf=True))

    def core(self, joints: Labels) -> tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """(kind, gain, vector, gradient) as the compiled core reads them, for an arm of these joints."""
        raise TypeError(f"{type(self).__name__} is a base class; use one of the null motions")


@dataclass(frozen=True, kw_only=True, eq=False)
class Rates(NullMotion):
    """Given reference rates (the paper's ν).

    Args:
        rates: (n,) [rad/s, m/s].
    """

    rates: npt.ArrayLike

    def core(self, joints: Labels) -> tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The given rates."""
        return NullMotionKind.RATES, 1.0, _vector("rates", self.rates, joints), None


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture(NullMotion):
    """Towards a posture: rates gain · (q_posture - q); joints that turn without end take the short way.

    A joint turns without end where it is revolute and has no position limits.

    Args:
        q: (n,) [rad, m], or by joint name.
        gain: [1/s].
    """

    q: npt.ArrayLike
    gain: float = 1.0

    def core(self, joints: Labels) -> tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The posture and its gain."""
        return NullMotionKind.POSTURE, _door.positive("gain", self.gain), _vector("q", self.q, joints), None


@dataclass(frozen=True, kw_only=True, eq=False)
class Centring(NullMotion):
    """Towards the middle of the position limits; joints without two limits are left alone.

    Args:
        gain: [1/s].
    """

    gain: float = 1.0

    def core(self, joints: Labels) -> tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The gain."""
        return NullMotionKind.CENTRING, _door.positive("gain", self.gain), None, None


@dataclass(frozen=True, kw_only=True, eq=False)
class Manipulability(NullMotion):
    """Away from singularities: rates gain · ∇ ln √det(J Jᵀ) of the working joints' task Jacobian (Yoshikawa, 1985).

    The gradient is analytic. Where it is exactly zero by symmetry (a planar arm has no way to know that it could leave
    its plane) a push of a hundredth of ``max_rate``, the same in every run, lets the arm leave.

    Args:
        gain: [rad²/s].
    """

    gain: float = 1.0
    max_rate: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        _door.positive("max_rate", self.max_rate)  # near a singularity the gradient has no bound of its own

    def core(self, joints: Labels) -> tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The gain."""
        return NullMotionKind.MANIPULABILITY, _door.positive("gain", self.gain), None, None


@dataclass(frozen=True, kw_only=True, eq=False)
class Gradient(NullMotion):
    """Along a gradient of yours: rates gain · gradient.

    Args:
        gradient: (n,), or a callable q (n,) -> (n,) that is evaluated once a tick. Inside a running loop a callable
            that fails, or answers with something else, switches the null motion off for that tick (INVALID_INPUT).
            KeyboardInterrupt and SystemExit are raised.
        gain: rates per unit of the gradient.
    """

    gradient: npt.ArrayLike | Callable[[npt.NDArray[np.float64]], npt.ArrayLike]
    gain: float = 1.0

    def core(self, joints: Labels) -> tuple[NullMotionKind, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The gradient and its gain."""
        gain = _door.positive("gain", self.gain)
        if callable(self.gradient):
            return NullMotionKind.GRADIENT, gain, None, self.gradient
        return NullMotionKind.GRADIENT, gain, _vector("gradient", self.gradient, joints), None


def checked_null_motion(value: Any, joints: Labels) -> NullMotion | None:
    """A null motion, or None; bare rates become Rates. InputError for anything else."""
    if value is None or isinstance(value, NullMotion):
        return value
    try:
        return Rates(rates=_vector("null_motion", value, joints))
    except InputError:
        choices = f"Posture, Centring, Manipulability, Gradient, Rates, {len(joints.names)} rates or None"
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
