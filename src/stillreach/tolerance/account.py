"""A rehearsal in words: the verdict, the table, what would be better."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._words import joined, shown
from stillreach.simulation import Scenario, simulate
from stillreach.tolerance.cause import WORDS, Cause

if TYPE_CHECKING:
    from stillreach.tolerance.rehearsal import Rehearsal

HEAD = ("fails", "survives", "position alone", "worst error", "lost", "mostly because of")
"""Columns of the table."""


def verdict(of: Rehearsal) -> str:
    """The result in one or two sentences."""
    count = int(np.count_nonzero(of.done))
    if not count:
        return "No failure was rehearsed."
    first = f"The arm survives {percent(of.share)} of {count} failures{_within(of)}"
    if not of.healthy_survives:
        off = float(np.nanmax(of.healthy_distance)), float(np.nanmax(of.healthy_angle))
        return f"{first}; but without a failure it is itself up to {_errors(of, off)} off."
    bad = [which for which in of.ranking if of.gaps(which)]
    if not bad:
        return f"{first}: every one, and the tool stays within {_errors(of, of.worst_of(slice(None)))}."
    always = [of.joints[which] for which in bad if when(of, which) == "at any time"]
    texts = [f"{joined(always[:6], 'or')} at any time" + _more(always, 6)] if always else []
    some = [which for which in bad if when(of, which) != "at any time"]
    texts += [f"{of.joints[which]} {when(of, which)}" for which in some[:4]]
    text = f"{first}. It cannot lose {'; nor '.join(texts)}{_more(some, 4)}"
    good = [which for which in range(len(of.joints)) if which not in bad]
    if good:
        names = joined([of.joints[which] for which in good[:6]], "and") + _more(good, 6)
        text += f". It can lose {names} at any time, and stays within {_errors(of, of.worst_of(good))}"
    return f"{text}."


def when(of: Rehearsal, which: int, kind: int | None = None) -> str:
    """When a set of joints cannot fail, in words."""
    last, onset = len(of.onset) - 1, of.onset
    words = []
    for a, b in of.gaps(which, kind):
        if (a, b) == (0, last):
            return "at any time"
        if a == b:
            words.append(f"at {onset[a]:.3g} s")
        elif a == 0:
            words.append(f"until {onset[b]:.3g} s")
        elif b == last:
            words.append(f"from {onset[a]:.3g} s on")
        else:
            words.append(f"between {onset[a]:.3g} and {onset[b]:.3g} s")
    more = ["once more" if len(words) == 4 else f"{len(words) - 3} more times"] if len(words) > 3 else []
    return joined([*words[:3], *more], "and") if words else "never"


def table(of: Rehearsal) -> Iterator[tuple[str, ...]]:
    """Rows for HEAD: the joints that fail, from the worst on; kinds together."""
    for which in of.ranking:
        done = of.done[:, which]
        count = max(int(np.sum(done)), 1)
        lost = done & ~of.survives[:, which]
        causes = [Cause(int(code)) for code in np.unique(of.cause[:, which][lost])]
        most = max(causes, key=lambda cause: int(np.sum(of.cause[:, which] == cause)), default=None)
        text = "" if most is None else WORDS[most] + _of_joint(of, which, most)
        shares = (np.sum(of.survives[:, which]) / count, np.sum(of.survives_position[:, which]) / count)
        worst = _errors(of, of.worst_of([which])) if done.any() else ""
        yield (of.joints[which], *map(percent, shares), worst, when(of, which), text)


def _of_joint(of: Rehearsal, which: int, cause: Cause) -> str:
    """`` of panda_joint2`` where the limit is mostly that joint's."""
    joints = of.limited_by[:, which][of.cause[:, which] == cause]
    joints = joints[joints >= 0]
    if not len(joints):
        return ""
    return f" of {of.scenario.arm.joint_names[int(np.argmax(np.bincount(joints)))]}"


def advice(of: Rehearsal) -> str:
    """What another start posture or place would change, in words; empty where none is known."""
    place = ""
    if of.moved is not None:
        where = ", ".join(shown(float(value), "m") for value in of.shift)
        less = f"{percent(of.moved.share)} survive instead of {percent(of.share)}"
        place = f"With the task moved by ({where}) {less}."
    if of.better is None:
        return place
    arm, start = of.scenario.arm, of.better.scenario.start
    names = zip(arm.joint_names, start, arm.joint_units, strict=True)
    posture = ", ".join(f"{name} {shown(value, unit)}" for name, value, unit in names)
    less = f"{percent(of.better.share)} survive instead of {percent(of.share)}"
    motion = of.better.scenario.null_motion
    moving = "" if motion is of.scenario.null_motion else f" and the null motion {motion!r}"
    price = _price(of.scenario, of.better.scenario)
    return f"From another start posture{moving} {less}: {posture}. {price}{' ' if place else ''}{place}"


def described(of: Rehearsal) -> str:
    """What was rehearsed, in a line."""
    kinds, sets, moments = of.failures.shape
    count = f"{len(of.failures.sets[0])} joints" if len(of.failures.sets[0]) > 1 else "joint"
    known = of.failures.known_after
    delay = "at once" if not known else "never" if np.isinf(known) else f"after {1000 * known:g} ms"
    ticks = f"{of.ticks / 1e6:.3g} million ticks of {1000 * of.scenario.period:g} ms in {of.seconds:.2g} s"
    names = ", ".join(of.kinds)
    return (
        f"{of.scenario.arm.name}, {kinds * sets * moments} failures: {names}; {sets} times {count}, "
        f"{moments} moments; known {delay}; {ticks}"
    )


def facts(of: Rehearsal) -> dict[str, Any]:
    """The main numbers, for JSON; docs/rehearsal.md explains them."""
    lost = of.done & ~of.survives
    return {
        "scenario": of.scenario.title,
        "arm": of.scenario.arm.name,
        "law": str(of.scenario.law),
        "verdict": of.verdict,
        "share": of.share,
        "failures": int(np.count_nonzero(of.done)),
        "complete": not of.interrupted,
        "kinds": list(of.kinds),
        "onsets": of.onset.tolist(),
        "known_after": of.failures.known_after,
        "allowed": {"distance": of.limits[0], "angle": of.limits[1]},
        "healthy": {
            "survives": of.healthy_survives,
            "distance": float(np.max(of.healthy_distance)),
            "angle": float(np.max(of.healthy_angle)),
        },
        "joints": {
            of.joints[which]: {
                "share": of.share_of(which),
                "worst_distance": of.worst_of([which])[0] if of.done[:, which].any() else None,
                "worst_angle": of.worst_of([which])[1] if of.done[:, which].any() else None,
                "lost": [[float(of.onset[a]), float(of.onset[b])] for a, b in of.gaps(which)],
                "causes": {
                    WORDS[cause]: int(np.sum(of.cause[:, which][lost[:, which]] == cause))
                    for cause in Cause
                    if np.any(of.cause[:, which][lost[:, which]] == cause)
                },
            }
            for which in of.ranking
        },
        "better": None
        if of.better is None
        else {
            "share": of.better.share,
            "start": dict(zip(of.scenario.arm.joint_names, of.better.scenario.start.tolist(), strict=True)),
            "advice": of.advice,
        },
        "moved": None
        if of.moved is None
        else {"share": of.moved.share, "shift": of.shift.tolist(), "advice": of.advice},
        "survey": None if of.survey is None else of.survey.facts(),
        "ticks": of.ticks,
        "seconds": of.seconds,
    }


def _price(own: Scenario, other: Scenario) -> str:
    """What a start posture costs without a failure: rates, and room to the position limits."""
    rates, rooms = [], []
    for scenario in (own, other):
        run = simulate(scenario, progress=False)
        low, high = scenario.arm.position_limits.T
        peak = run.summary().rate
        rates.append("without a limit" if peak is None else f"{percent(peak.value)} of a joint's limit")
        room = float(np.min(np.minimum(run.q - low, high - run.q)))
        rooms.append(f"{room:.2g} rad or m" if np.isfinite(room) else "endless")
    return (
        f"Without a failure its largest rate is {rates[1]} (else {rates[0]}), and the least room to a position limit "
        f"{rooms[1]} (else {rooms[0]})."
    )


def percent(share: float) -> str:
    """Whole percents; 100 and 0 only where they are meant."""
    if np.isnan(share):
        return ""
    rounded = round(100 * float(share))
    if (rounded == 100 and share < 1.0) or (rounded == 0 and share > 0.0):
        return f"{100 * share:.1f} %"
    return f"{rounded} %"


def _errors(of: Rehearsal, off: tuple[float, float]) -> str:
    """A distance and an angle, each if the task has it."""
    rows = of.scenario.task.indices if of.scenario.task else range(6)
    texts = [f"{1000 * off[0]:.3g} mm"] if min(rows) < 3 else []
    texts += [f"{np.rad2deg(off[1]):.3g} deg"] if max(rows) >= 3 else []
    return " and ".join(texts)


def _within(of: Rehearsal) -> str:
    return f" (allowed: {_errors(of, of.limits)})"


def _more(names: Sequence[Any], shown: int) -> str:
    return f" and {len(names) - shown} more" if len(names) > shown else ""
