"""What to do with the freedom that the task leaves: each is a reference rate that the law stays near."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach.errors import InputError

# NullMotionKind of the core
NONE, RATES, POSTURE, CENTRING, MANIPULABILITY, GRADIENT = range(6)


@dataclass(frozen=True, kw_only=True, eq=False)
class NullMotion:
    """Base of all null motions.

    Args:
        max_rate: largest rate [rad/s, m/s] that is asked of any joint; all are scaled down together.
    """

    max_rate: float = float("inf")

    def __post_init__(self) -> None:
        object.__setattr__(self, "max_rate", _door.positive("max_rate", self.max_rate, allow_inf=True))

    def core(self, n: int) -> tuple[int, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """(kind, gain, vector, gradient) as the compiled core reads them, for n joints."""
        raise TypeError(f"{type(self).__name__} is a base class; use one of the null motions")


@dataclass(frozen=True, kw_only=True, eq=False)
class Rates(NullMotion):
    """Given reference rates (the paper's ν).

    Args:
        rates: (n,) [rad/s, m/s].
    """

    rates: npt.ArrayLike

    def core(self, n: int) -> tuple[int, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The given rates."""
        return RATES, 1.0, _door.vector("rates", self.rates, n), None


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture(NullMotion):
    """Towards a posture: rates gain · (q_posture - q).

    Args:
        q: (n,) [rad, m].
        gain: [1/s].
    """

    q: npt.ArrayLike
    gain: float = 1.0

    def core(self, n: int) -> tuple[int, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The posture and its gain."""
        return POSTURE, _door.positive("gain", self.gain), _door.vector("q", self.q, n), None


@dataclass(frozen=True, kw_only=True, eq=False)
class Centring(NullMotion):
    """Towards the middle of the position limits; joints without two limits are left alone.

    Args:
        gain: [1/s].
    """

    gain: float = 1.0

    def core(self, n: int) -> tuple[int, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The gain."""
        return CENTRING, _door.positive("gain", self.gain), None, None


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

    def core(self, n: int) -> tuple[int, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The gain."""
        return MANIPULABILITY, _door.positive("gain", self.gain), None, None


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

    def core(self, n: int) -> tuple[int, float, npt.ArrayLike | None, Callable[..., object] | None]:
        """The gradient and its gain."""
        gain = _door.positive("gain", self.gain)
        if callable(self.gradient):
            return GRADIENT, gain, None, self.gradient
        return GRADIENT, gain, _door.vector("gradient", self.gradient, n), None


def null_motion_settings(
    value: object, n: int
) -> tuple[int, float, float, npt.ArrayLike | None, Callable[..., object] | None]:
    """(kind, gain, largest rate, vector, gradient) of a null motion, of bare rates, or of None."""
    if value is None:
        return NONE, 0.0, float("inf"), None, None
    if not isinstance(value, NullMotion):
        try:
            value = Rates(rates=_door.vector("null_motion", value, n))
        except InputError:
            raise InputError(
                "null_motion",
                _door.describe(value),
                f"Posture, Centring, Manipulability, Gradient, Rates, {n} rates or None",
            ) from None
    kind, gain, vector, gradient = value.core(n)
    return kind, gain, value.max_rate, vector, gradient
