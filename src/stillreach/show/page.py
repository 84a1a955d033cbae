"""The page of a rehearsal: one HTML file that needs no network."""

from __future__ import annotations

import json
import math
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stillreach._core import instruction_set
from stillreach._words import joined
from stillreach.arm.shapes import stations
from stillreach.errors import MissingExtraError, PageNotBuiltError
from stillreach.page import built, page_parts
from stillreach.page.pack import compressed
from stillreach.page.task import changes_of
from stillreach.plants import KinematicPlant
from stillreach.show.heat import colour, columns, heading, legend
from stillreach.show.left import left_html
from stillreach.simulation import simulate
from stillreach.simulation.schedule import fault_changes
from stillreach.tolerance.cause import WORDS, Cause
from stillreach.tolerance.failures import KINDS

if TYPE_CHECKING:
    from stillreach.simulation import Run
    from stillreach.tolerance import Rehearsal
    from stillreach.tolerance.rehearsal import Place

CELL, ROW, LEFT = 720, 22, 150
"""Sizes of a heat map: width of the cells, height of a row, space for the names."""
PICTURES = 3
VIEW = np.deg2rad(-50.0), np.deg2rad(22.0)
"""Azimuth and elevation of the pictures of the arm."""


def rehearsal_page(found: Rehearsal, source: str) -> str:
    """The page as text.

    Args:
        found: the rehearsal.
        source: what a command calls the task.

    Raises:
        MissingExtraError: if Jinja is not installed.
    """
    try:
        import jinja2
    except ImportError as error:
        raise MissingExtraError("page", "the page of a rehearsal") from error
    folder = resources.files("stillreach.show")
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    template = environment.from_string((folder / "rehearsal.html").read_text(encoding="utf-8"))
    maps = [_heat_map(found, kind, source) for kind in range(len(found.kinds))]
    return template.render(
        title=found.scenario.title,
        found=found,
        maps=maps,
        legend=legend(),
        rows=list(found.table()),
        pictures=list(_pictures(found, source)),
        cells=compressed(json.dumps([cell for made in maps for cell in made.cells])),
        left="" if found.survey is None else left_html(found.survey, len(found.scenario.faults)),
        facts=_how(found, source),
        live=_live(found),
        css=(folder / "rehearsal.css").read_text(encoding="utf-8"),
    )


def _live(found: Rehearsal) -> dict[str, str] | None:
    """The live arm of the page; None where this installation has no program for it."""
    try:
        parts = page_parts(found.scenario, planned=True)
    except PageNotBuiltError:
        return None
    return {**parts, "style": built("page.css")}


class _Cell(NamedTuple):
    """A rectangle of a heat map."""

    x: float
    y: float
    width: float
    colour: str
    lost: bool
    case: int


class _HeatMap(NamedTuple):
    """A heat map of a kind of failures: joint by onset."""

    kind: str
    share: str
    height: int
    rects: list[_Cell]
    names: list[tuple[float, str]]
    ticks: list[tuple[float, str]]
    cells: list[dict[str, Any]]


def _heat_map(found: Rehearsal, kind: int, source: str) -> _HeatMap:
    made = columns(found, kind)
    width, order = CELL / len(made), found.ranking
    before = kind * len(order) * len(made)
    rects, cells = list[_Cell](), list[dict[str, Any]]()
    for row, which in enumerate(order):
        for place, column in enumerate(made):
            told = _told(found, (kind, which, int(column.places[which])), source)
            shade, lost = colour(float(column.excess[which])), bool(column.lost[which])
            rects.append(_Cell(LEFT + place * width, row * ROW, width, shade, lost, before + len(cells)))
            cells.append(told)
    names = [(row * ROW + 0.5 * ROW, _short(found.joints[which])) for row, which in enumerate(order)]
    return _HeatMap(*heading(found, kind), ROW * len(order), rects, names, _times(found), cells)


def _told(found: Rehearsal, place: Place, source: str) -> dict[str, Any]:
    """What a reader is told of a case."""
    cause = Cause(int(found.cause[place]))
    if cause == Cause.NOT_DONE:
        what = WORDS[cause]
    else:
        worst = _off(found.worst_distance[place], found.worst_angle[place])
        what = f"up to {worst} off, {_off(found.final_distance[place], found.final_angle[place])} at the end"
        if cause != Cause.SURVIVES:
            joint = int(found.limited_by[place])
            of = f" of {found.scenario.arm.joint_names[joint]}" if joint >= 0 else ""
            what = f"{WORDS[cause]}{of} at {found.failed_time[place]:.3g} s; {what}"
    return {
        "joint": found.joints[place[1]],
        "kind": found.kinds[place[0]],
        "when": f"fails at {found.onset[place[2]]:.3g} s",
        "what": what,
        "command": found.command(place, source),
        "play": _played(found, place),
        "allowed": [float(limit) if np.isfinite(limit) else None for limit in found.limits],
        "survives": cause == Cause.SURVIVES,
    }


def _played(found: Rehearsal, place: Place) -> dict[str, Any]:
    """A case as the live arm plays it."""
    scenario, failures = found.scenario, found.failures
    faults = [*scenario.faults, *failures.faults(scenario, place, found.q[place[2]])]
    true, known = fault_changes(scenario, faults)
    delayed = bool(failures.known_after) or any(fault.known_after for fault in scenario.faults)
    plant = scenario.plant
    return {
        "onset": int(failures.ticks[place[2]]),
        "changes": changes_of(true),
        "known": changes_of(known),
        "delayed": delayed or not (isinstance(plant, KinematicPlant) and plant.exact),
    }


def _off(distance: float, angle: float) -> str:
    return f"{1000 * distance:.3g} mm and {math.degrees(angle):.3g} deg"


def _times(found: Rehearsal) -> list[tuple[float, str]]:
    """Places and texts of the times below a heat map."""
    end = float(found.onset[-1]) if len(found.onset) > 1 else 0.0
    if end <= 0.0:
        return [(LEFT + 0.5 * CELL, f"{found.onset[0]:g} s")]
    step = 10.0 ** math.floor(math.log10(end))
    step = next(step * part for part in (0.1, 0.2, 0.25, 0.5, 1.0, 2.0) if end / (step * part) <= 10.0)
    span = end * len(found.onset) / (len(found.onset) - 1)
    return [(LEFT + CELL * step * k / span, f"{step * k:g} s") for k in range(int(end / step + 1e-9) + 1)]


def _short(name: str) -> str:
    return name if len(name) <= 22 else f"{name[:21]}…"


class _Picture(NamedTuple):
    """The arm at the moment at which it left its tolerance."""

    title: str
    text: str
    command: str
    links: str
    path: str
    actual: str
    joints: list[tuple[float, float, bool]]
    tool: tuple[float, float]
    goal: tuple[float, float]
    box: str


def _pictures(found: Rehearsal, source: str) -> list[_Picture]:
    """The worst case of each of the worst sets of joints."""
    excess = np.where(found.done & ~found.survives, found.excess, -1.0)
    chosen = [which for which in found.ranking if np.max(excess[:, which]) > 0.0][:PICTURES]
    pictures = []
    for which in chosen:
        kind, moment = np.unravel_index(int(np.argmax(excess[:, which])), excess[:, which].shape)
        place = (int(kind), which, int(moment))
        run = simulate(
            found.case(found.kinds[place[0]], found.failures.sets[which], found.onset[moment]), progress=False
        )
        pictures.append(_picture(found, place, run, source))
    return pictures


def _picture(found: Rehearsal, place: Place, run: Run, source: str) -> _Picture:
    told, summary = _told(found, place, source), run.summary()
    tick = min(round(float(found.worst_time[place]) / run.scenario.period), len(run) - 1)
    points, _ = stations(run.scenario.arm, run.q[tick])
    tool = run.pose[tick, :3, 3]
    flat = _projected(np.concatenate([points, [tool]]))
    path, actual = _projected(run.target[:, :3, 3]), _projected(run.pose[:, :3, 3])
    goal = _projected(run.target[tick : tick + 1, :3, 3])[0]
    everything = np.concatenate([flat, path, actual])
    low, high = everything.min(axis=0), everything.max(axis=0)
    room = 0.08 * float(np.max(high - low)) + 1e-3
    low, size = low - room, high - low + 2.0 * room
    failed = set(found.failures.sets[place[1]])
    joints = [
        (float(x), float(y), moving.leader in failed)
        for (x, y), moving in zip(flat[1:], run.scenario.arm.chain, strict=False)
    ]
    why = f" {summary.why.sentence[0].upper()}{summary.why.sentence[1:]}." if summary.why else ""
    return _Picture(
        title=f"{told['joint']} {told['when']} ({told['kind']})",
        text=f"{told['what'][0].upper()}{told['what'][1:]}. Drawn at {run.time[tick]:.3g} s.{why}",
        command=told["command"],
        links=_line(flat),
        path=_line(_thinned(path)),
        actual=_line(_thinned(actual)),
        joints=joints,
        tool=(float(flat[-1, 0]), float(flat[-1, 1])),
        goal=(float(goal[0]), float(goal[1])),
        box=f"{low[0]:.4f} {low[1]:.4f} {size[0]:.4f} {size[1]:.4f}",
    )


def _projected(points: np.ndarray) -> np.ndarray:
    """(K, 2) points (K, 3) as the page shows them, y downwards."""
    azimuth, elevation = VIEW
    across = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.array([-np.sin(elevation) * np.cos(azimuth), -np.sin(elevation) * np.sin(azimuth), np.cos(elevation)])
    flat = np.empty((len(points), 2))
    flat[:, 0], flat[:, 1] = points @ across, -(points @ up)
    return flat


def _thinned(points: np.ndarray) -> np.ndarray:
    thinned: np.ndarray = points[np.unique(np.linspace(0, len(points) - 1, 300).astype(int))]
    return thinned


def _line(points: np.ndarray) -> str:
    return " ".join(f"{x:.4f},{y:.4f}" for x, y in points)


def _how(found: Rehearsal, source: str) -> list[tuple[str, str]]:
    """How it was computed."""
    from importlib.metadata import version

    scenario, known = found.scenario, found.failures.known_after
    delay = "at once" if not known else "never" if math.isinf(known) else f"{1000 * known:g} ms later"
    own = [f"{fault.joint} ({fault.kind.word}) at {fault.at:g} s" for fault in scenario.faults]
    kinds = [f"{kind} ({KINDS[kind][1]})" if kind in KINDS else kind for kind in found.kinds]
    healthy = _off(float(np.max(found.healthy_distance)), float(np.max(found.healthy_angle)))
    made = found.survey
    still = (
        f"{made.configurations:,} moments; a pose counts as lost if none of {made.starts} searches reaches it"
        if made
        else ""
    )
    rule = f"the tool stays within {_off(*found.limits)} of its target from the failure on to the end"
    return [
        ("task", f"{scenario.title}: {source}"),
        ("path", f"{found.way[0]:.4g} m and {math.degrees(found.way[1]):.4g} deg in {scenario.duration:g} s"),
        ("arm", f"{scenario.arm.name}, {scenario.arm.n} joints"),
        ("other faults", joined(own, "and") if own else "none"),
        ("failures", f"{', '.join(kinds)}; at {len(found.onset)} moments"),
        ("controller", f"{scenario.law}, every {1000 * scenario.period:g} ms, {scenario.loop} loop"),
        ("null motion", str(scenario.null_motion) if scenario.null_motion is not None else "none"),
        ("it knows", f"of a failure {delay}"),
        ("survived", rule),
        ("without a failure", f"up to {healthy} off"),
        *([("where it can go", still)] if made else []),
        ("simulated", f"{found.ticks:,} ticks in {found.seconds:.3g} s, each case to the end"),
        ("program", f"stillreach {version('stillreach')}, {instruction_set()} instructions"),
    ]
