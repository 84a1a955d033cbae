"""The result of a rehearsal: what became of each failure, by kind, joints and moment."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._files import new_file
from stillreach._messages import one_of
from stillreach._words import aligned
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation import Scenario
from stillreach.tolerance import account
from stillreach.tolerance.cause import WORDS, Cause
from stillreach.tolerance.failures import Failures

if TYPE_CHECKING:
    import os

    import xarray
    from matplotlib.figure import Figure

    from stillreach.tolerance.survey import Survey

LEAST_ALLOWED = 1e-12
"""[m, rad]"""
Place = tuple[int, int, int]
"""Kind, set of joints, moment."""


@dataclass(eq=False, repr=False, kw_only=True)
class Rehearsal:
    """What became of every failure.

    Arrays have the axes kind, joints and onset, (K, S, T); those of cases that were not done are NaN.

    Args:
        scenario: the task, with the faults that every failure comes on top of.
        failures: the cases.
        limits: the allowed distance [m] and angle [rad].
        way: length [m] and angle [rad] of the commanded path.
        q: (T, n) where the joints stand at each onset [rad, m].
        cause: (K, S, T) of Cause: SURVIVES, or why the tool left its tolerance.
        limited_by: (K, S, T) index of the joint whose limit that is, or -1.
        worst_distance, worst_angle: (K, S, T) [m, rad] the largest from the onset on.
        worst_time: (K, S, T) [s] when the distance is largest.
        final_distance, final_angle: (K, S, T) [m, rad] at the end.
        delay_distance, delay_angle: (K, S, T) [m, rad] when the controller learned of the failure.
        failed_time: (K, S, T) [s] when the tool left its tolerance; NaN where it did not.
        healthy_distance, healthy_angle: (ticks,) [m, rad] of the arm without a failure.
        seconds: how long the rehearsal took.
        interrupted: whether Ctrl-C ended it early.
        better: the same from a better start posture, where ``better_start`` found one.
        moved: the same with the task moved by ``shift`` (3,) [m], where ``better_place`` found a better place.
        shift: (3,) [m] along the base axes; empty where none was found.
        survey: of the configurations along the task, where ``survey_along`` made it.
    """

    scenario: Scenario
    failures: Failures
    limits: tuple[float, float]
    way: tuple[float, float]
    q: FloatArray
    cause: npt.NDArray[np.int8]
    limited_by: npt.NDArray[np.int16]
    worst_distance: FloatArray
    worst_angle: FloatArray
    worst_time: FloatArray
    final_distance: FloatArray
    final_angle: FloatArray
    delay_distance: FloatArray
    delay_angle: FloatArray
    failed_time: FloatArray
    healthy_distance: FloatArray
    healthy_angle: FloatArray
    seconds: float = 0.0
    interrupted: bool = False
    better: Rehearsal | None = None
    moved: Rehearsal | None = None
    shift: FloatArray = field(default_factory=lambda: np.zeros(0))
    survey: Survey | None = None

    @classmethod
    def empty(
        cls, scenario: Scenario, failures: Failures, limits: tuple[float, float], way: tuple[float, float]
    ) -> Rehearsal:
        """One of which nothing is done yet."""
        arrays: dict[str, Any] = {name: np.full(failures.shape, np.nan) for name in MEASURED}
        for name in ("healthy_distance", "healthy_angle"):
            arrays[name] = np.full(scenario.steps + 1, np.nan)
        return cls(
            scenario=scenario,
            failures=failures,
            limits=limits,
            way=way,
            q=np.full((failures.shape[2], scenario.arm.n), np.nan),
            cause=np.full(failures.shape, Cause.NOT_DONE, dtype=np.int8),
            limited_by=np.full(failures.shape, -1, dtype=np.int16),
            **arrays,
        )

    @property
    def onset(self) -> FloatArray:
        """(T,) [s] the moments."""
        return np.asarray(self.failures.ticks * self.scenario.period)

    @property
    def kinds(self) -> tuple[str, ...]:
        """(K,) the kinds of failures."""
        return self.failures.kinds

    @property
    def joints(self) -> tuple[str, ...]:
        """(S,) names of the joints that fail, ``"j2 + j4"`` where several do."""
        names = self.scenario.arm.joint_names
        return tuple(" + ".join(names[joint] for joint in joints) for joints in self.failures.sets)

    @property
    def done(self) -> npt.NDArray[np.bool_]:
        """(K, S, T) which cases are done."""
        return np.asarray(self.cause != Cause.NOT_DONE)

    @property
    def survives(self) -> npt.NDArray[np.bool_]:
        """(K, S, T) whether the tool stayed within both tolerances."""
        return np.asarray(self.cause == Cause.SURVIVES)

    @property
    def survives_position(self) -> npt.NDArray[np.bool_]:
        """(K, S, T) whether the tool's place stayed within its tolerance, whatever its attitude did."""
        return np.asarray(self.worst_distance <= self.limits[0])

    @property
    def excess(self) -> FloatArray:
        """(K, S, T) the largest error as a multiple of what is allowed: of the distance or the angle, the larger."""
        near, turned = (max(limit, LEAST_ALLOWED) for limit in self.limits)
        return np.asarray(np.maximum(self.worst_distance / near, self.worst_angle / turned))

    @property
    def share(self) -> float:
        """The share of the failures that are survived, 0 to 1; NaN if none is done."""
        count = int(np.count_nonzero(self.done))
        return float(np.count_nonzero(self.survives)) / count if count else np.nan

    @property
    def ticks(self) -> int:
        """How many ticks were simulated, those of the healthy run included."""
        left = self.scenario.steps + 1 - self.failures.ticks
        return int(np.sum(self.done * left) + self.scenario.steps + 1)

    @property
    def healthy_survives(self) -> bool:
        """Whether the arm without a failure stays within the tolerances from the first onset on."""
        first = int(self.failures.ticks[0])
        near, turned = self.limits
        return bool(np.all(self.healthy_distance[first:] <= near) and np.all(self.healthy_angle[first:] <= turned))

    def case(self, kind: str, joints: str | int | Sequence[str | int], onset: float) -> Scenario:
        """The scenario of one case, for ``simulate``: it gives the ticks of the rehearsal to the last bit.

        Args:
            kind: one of ``kinds``.
            joints: one of ``joints``, or the names or indices of the joints that fail.
            onset: [s] the nearest of the moments is taken.

        Raises:
            InputError: if there is no such case.
        """
        return self._scenario_at(self._place(kind, joints, onset))

    def _scenario_at(self, place: Place) -> Scenario:
        faults = self.failures.faults(self.scenario, place, self.q[place[2]])
        return replace(self.scenario, faults=(*self.scenario.faults, *faults))

    def _place(self, kind: Any, joints: Any, onset: Any) -> Place:
        if kind not in self.kinds:
            raise InputError("kind", _door.describe(kind), one_of(self.kinds, kind))
        if isinstance(joints, str) and joints in self.joints:
            which = self.joints.index(joints)
        else:
            given: list[Any] = [joints] if isinstance(joints, str | int | np.integer) else list(joints)
            indices = tuple(sorted(self.scenario.arm.joint_index(joint) for joint in given))
            sets = [tuple(sorted(joints)) for joints in self.failures.sets]
            if indices not in sets:
                raise InputError("joints", _door.describe(joints), one_of(self.joints[:20]))
            which = sets.index(indices)
        moment = _door.scalar("onset", onset)
        return self.kinds.index(kind), which, int(np.argmin(np.abs(self.onset - moment)))

    def command(self, place: Place, source: str) -> str:
        """The command that simulates a case of a task that a command knows as ``source``."""
        parts = ["stillreach run", source]
        faults = self.failures.faults(self.scenario, place, self.q[place[2]])
        for fault in faults:
            name = self.scenario.arm.joint_names[self.scenario.arm.joint_index(fault.joint)]
            values = ",".join(_spoken(number) for number in vars(fault.kind).values())
            parts.append(f"--fail '{name}@{fault.at:.12g}:{fault.kind.word}{'=' if values else ''}{values}'")
        if self.failures.known_after:
            delay = self.failures.known_after
            parts.append("--known-after " + (f"{delay:.12g}" if np.isfinite(delay) else "never"))
        return " ".join(parts)

    def gaps(self, which: int, kind: int | None = None) -> list[tuple[int, int]]:
        """First and last moment (indices) of each range in which a set of joints cannot fail, of one or of any kind."""
        kinds = slice(None) if kind is None else slice(kind, kind + 1)
        lost = np.any(self.done[kinds, which] & ~self.survives[kinds, which], axis=0)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]])))
        return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]

    @property
    def ranking(self) -> list[int]:
        """The sets of joints, from the one whose failure is survived least often on."""
        done = np.maximum(np.sum(self.done, axis=(0, 2)), 1)
        shares = np.sum(self.survives, axis=(0, 2)) / done
        worst = np.nan_to_num(np.max(np.nan_to_num(self.worst_distance, nan=0.0), axis=(0, 2)))
        return sorted(range(len(shares)), key=lambda which: (shares[which], -worst[which]))

    def share_of(self, which: int) -> float:
        """The share of the failures of a set of joints that are survived."""
        return int(np.sum(self.survives[:, which])) / max(int(np.sum(self.done[:, which])), 1)

    def worst_of(self, which: Any) -> tuple[float, float]:
        """[m] and [rad]: the largest errors of some sets of joints."""
        distance, angle = self.worst_distance[:, which], self.worst_angle[:, which]
        return float(np.nanmax(distance)), float(np.nanmax(angle))

    def when(self, which: int, kind: int | None = None) -> str:
        """When a set of joints cannot fail, in words."""
        return account.when(self, which, kind)

    @property
    def verdict(self) -> str:
        """The result in one or two sentences."""
        return account.verdict(self)

    def table(self) -> Iterator[tuple[str, ...]]:
        """Rows below the table's heads: the joints that fail, from the worst on; kinds together."""
        return account.table(self)

    @property
    def advice(self) -> str:
        """What another start posture or place would change, in words; empty where none is known."""
        return account.advice(self)

    @property
    def described(self) -> str:
        """What was rehearsed, in a line."""
        return account.described(self)

    def __str__(self) -> str:
        return "\n".join([aligned([account.HEAD, *self.table()]), "", self.verdict, *filter(None, [self.advice])])

    def __repr__(self) -> str:
        kinds, sets, moments = self.failures.shape
        shape = f"{kinds} kinds x {sets} joints x {moments} moments"
        return f"<Rehearsal of {self.scenario.title!r}: {shape}, {account.percent(self.share)} survive>"

    def facts(self) -> dict[str, Any]:
        """The main numbers, for JSON; docs/rehearsal.md explains them."""
        return account.facts(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the arrays to a netCDF file (extra ``netcdf``), with their labels.

        Raises:
            MissingExtraError: if xarray or h5netcdf is not installed.
            OSError: if the file cannot be written.
        """
        found = self.to_xarray()
        try:
            import h5netcdf  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("netcdf", "rehearsal.save()") from error
        with new_file(path) as file:
            file.write(bytes(found.to_netcdf(engine="h5netcdf")))

    def plot(self) -> Figure:
        """A figure: the verdict, and for each kind of failures the largest error by joint and onset.

        Raises:
            MissingExtraError: if matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.heat import heat_maps

        return heat_maps(self)

    def html(self, source: str = "SCENARIO") -> str:
        """A page that needs no network: verdict, heat map, joints with reasons, and the command that replays each case.

        Args:
            source: what a command calls the task, e.g. ``"panda-elbow"`` or ``"--recording drive.csv --robot panda"``.

        Raises:
            MissingExtraError: if Jinja is not installed (extra ``page``).
        """
        from stillreach.show.page import rehearsal_page

        return rehearsal_page(self, source)

    def page(self, path: str | os.PathLike[str], source: str = "SCENARIO") -> None:
        """Write that page to a file.

        Raises:
            MissingExtraError: if Jinja is not installed (extra ``page``).
            OSError: if the file cannot be written.
        """
        text = self.html(source)
        with new_file(path) as file:
            file.write(text.encode())

    def to_xarray(self) -> xarray.Dataset:
        """The arrays by name, with the axes kind, joint and onset (extra ``netcdf``).

        Raises:
            MissingExtraError: if xarray is not installed.
        """
        try:
            import xarray
        except ImportError as error:
            raise MissingExtraError("netcdf", "rehearsal.to_xarray()") from error
        axes = ("kind", "joint", "onset")
        reasons = np.vectorize(lambda code: WORDS[Cause(code)])(self.cause)
        arrays = {name: getattr(self, name) for name in MEASURED}
        values = {"survives": self.survives, "survives_position": self.survives_position, "reason": reasons, **arrays}
        found = xarray.Dataset(
            {name: (axes, np.asarray(array)) for name, array in values.items()},
            coords={"kind": list(self.kinds), "joint": list(self.joints), "onset": self.onset},
            attrs={
                "title": self.scenario.title,
                "arm": self.scenario.arm.name,
                "law": str(self.scenario.law),
                "period": self.scenario.period,
                "known_after": self.failures.known_after,
                "allowed_distance": self.limits[0],
                "allowed_angle": self.limits[1],
                "share": self.share,
                "interrupted": int(self.interrupted),
            },
        )
        for name in arrays:
            found[name].attrs["units"] = "rad" if name.endswith("angle") else "s" if name.endswith("time") else "m"
        found["onset"].attrs["units"] = "s"
        return found


MEASURED = (
    "worst_distance",
    "worst_angle",
    "worst_time",
    "final_distance",
    "final_angle",
    "delay_distance",
    "delay_angle",
    "failed_time",
)
"""The measured arrays of a rehearsal."""


def _spoken(number: float) -> str:
    """A number of a fault as ``--fail`` reads it."""
    return f"{number:+g}" if abs(number) == 1.0 else repr(float(number))
