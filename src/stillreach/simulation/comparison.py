"""One scenario under several laws."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from stillreach import _door
from stillreach._words import aligned, shown_length, tidy
from stillreach.errors import InputError, SimulationInterrupted
from stillreach.laws import Law
from stillreach.simulation.account import apart, beyond_limits, is_late
from stillreach.simulation.run import Run
from stillreach.simulation.scenario import Scenario
from stillreach.simulation.simulator import simulate
from stillreach.simulation.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEAD = ("law", "arrived", "ends off by", "farthest off", "peak rate")


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Mapping[str, Run]):
    """Runs of one scenario by the name of the law; ``str()`` of it is a table.

    Args:
        scenario: what was run, but for the law.
        summaries: of the runs.
    """

    scenario: Scenario
    summaries: Mapping[str, Summary]

    def __getitem__(self, law: str) -> Run:
        return self.summaries[law].run

    def __iter__(self) -> Iterator[str]:
        return iter(self.summaries)

    def __len__(self) -> int:
        return len(self.summaries)

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the last run early."""
        return any(run.interrupted for run in self.values())

    def rows(self) -> list[tuple[str, ...]]:
        """Cells of the table, without its HEAD: how each law did."""
        return [
            (
                law,
                "broken off" if found.run.interrupted else "yes" if found.finished else "NO",
                apart(found, found.goal_distance, found.goal_angle),
                apart(found, found.distance.value, found.angle.value),
                "no limit" if found.rate is None else f"{tidy(100 * found.rate.value)} %",
            )
            for law, found in self.summaries.items()
        ]

    def notes(self) -> list[str]:
        """What the table does not say, in lines: why tools did not arrive, and which were late."""
        lines = ["peak rate: the largest, in per cent of its joint's limit"]
        if any(beyond_limits(found) for found in self.summaries.values()):
            lines.append("           above 100 %: drives cannot follow")
        for law, found in self.summaries.items():
            if found.why is not None:
                lines.append(f"{law}: {found.why.sentence}")
            if is_late(found):
                late, beside = shown_length(found.distance.value), shown_length(found.beside)
                lines.append(f"{law} falls behind, by up to {late}, and is at most {beside} off its path")
        return lines

    def plot(self) -> Figure:
        """A picture: where each law led the tool, how far off, at what rates.

        Raises:
            MissingExtraError: matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.comparison import comparison

        return comparison(self)

    def __str__(self) -> str:
        return "\n".join([self.scenario.title, aligned([HEAD, *self.rows()]), *self.notes()])

    def __repr__(self) -> str:
        return f"<Comparison {self.scenario.title!r}: {', '.join(self)}>"


def compare(
    scenario: Scenario,
    laws: Mapping[str, Law] | Iterable[Law],
    *,
    allowed_distance: float | None = None,
    allowed_angle: float | None = None,
    progress: bool | None = None,
) -> Comparison:
    """Simulate a scenario under several laws.

    Args:
        scenario: what to run.
        laws: by name, or laws that are then called by their classes.
        allowed_distance: [m] as for ``Run.summary``.
        allowed_angle: [rad] likewise.
        progress: as for ``simulate``.

    Raises:
        InputError: no law, something else than laws, or two of one class without names.
        SimulationInterrupted: Ctrl-C; ``.run`` of the error is a Comparison with every tick computed so far.
    """
    allowed = {"allowed_distance": allowed_distance, "allowed_angle": allowed_angle}
    summaries: dict[str, Summary] = {}
    for name, law in _named(laws).items():
        try:
            run = simulate(replace(scenario, law=law), progress=progress)
        except SimulationInterrupted as interrupt:
            if len(interrupt.run):
                summaries[name] = interrupt.run.summary(**allowed)
            raise SimulationInterrupted(Comparison(scenario, summaries)) from None
        summaries[name] = run.summary(**allowed)
    return Comparison(scenario, summaries)


def _named(laws: Any) -> dict[str, Law]:
    """The laws by name; InputError otherwise."""
    expected = "laws, or laws by name where two are of one class"
    given = laws.values() if isinstance(laws, Mapping) else laws
    if isinstance(laws, Law) or not isinstance(given, Iterable):
        raise InputError("laws", _door.describe(laws), expected)
    found = list(given)
    if not found or not all(isinstance(law, Law) for law in found):
        raise InputError("laws", _door.describe(laws), expected)
    names = list(map(str, laws)) if isinstance(laws, Mapping) else [type(law).__name__ for law in found]
    if len(set(names)) < len(names):
        raise InputError("laws", f"{', '.join(names)}", expected)
    return dict(zip(names, found, strict=True))
