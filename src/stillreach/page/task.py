"""What a page knows of a task: the arm, the controller as numbers, its other laws, the commands, the faults."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stillreach._core import STATUS
from stillreach._door import FloatArray
from stillreach._labels import TWIST
from stillreach.arm import Arm
from stillreach.arm.dexterity import full_rates
from stillreach.errors import InputError
from stillreach.laws import LAWS, Law
from stillreach.null_motions import Centring, Gradient, Manipulability, NullMotion, Posture, Tolerance
from stillreach.plants import KinematicPlant
from stillreach.simulation import Scenario
from stillreach.simulation.commanded import along_tool, asked
from stillreach.simulation.document import check_whole
from stillreach.simulation.orders import parts_of
from stillreach.simulation.schedule import Change
from stillreach.status import IN_WORDS, Health
from stillreach.tolerance.failures import KINDS

MOST_TICKS = 100_000
"""Largest number of ticks whose commands a page holds."""
NULL_RATE = 0.3
"""Largest rate of a page's own null motions, as a share of the median velocity limit."""


def task_of(scenario: Scenario, *, planned: bool) -> tuple[dict[str, Any], list[str]]:
    """What a page knows of a scenario, for ``pack``, and what it does not, in sentences.

    Args:
        scenario: the scenario.
        planned: whether the page plays its motion and faults; else the arm stands at the start.
    """
    notes: list[str] = []
    controller = scenario.controller()
    if isinstance(scenario.null_motion, Gradient) and callable(scenario.null_motion.gradient):
        notes.append("The null motion is a Python function, which the page leaves out when it computes.")
        controller.set_null_motion(None)
    planned = planned and _playable(scenario, notes)
    plant = scenario.plant if isinstance(scenario.plant, KinematicPlant) else KinematicPlant()
    if not isinstance(scenario.plant, KinematicPlant):
        notes.append("What the page computes moves the arm without inertia; recorded motion had it.")
    if planned and scenario.clock == "arm":
        notes.append("The motion waits for the arm; the page takes its commands to the nearest tick.")
    task = scenario.task
    assert task is not None
    noise = None
    if planned and plant.noise:
        random = np.random.default_rng(plant.seed)
        noise = random.normal(0.0, plant.noise, (scenario.steps + 1, scenario.arm.n))
    plan = scenario.schedule
    delays = any(fault.known_after for fault in scenario.faults)
    return {
        "title": scenario.title,
        "text": scenario.description,
        "arm": arm_of(scenario.arm, scenario.arm.tool if task.tool is None else scenario.arm.tool @ task.tool),
        "setup": setup_of(controller),
        "laws": list(_laws(scenario)),
        "nullMotions": list(_null_motions(scenario)),
        "plant": plant.settings(scenario.period),
        "hasPlant": not plant.exact or delays,
        "noise": noise,
        "start": scenario.start,
        "startPose": scenario.task_pose(scenario.start),
        "period": scenario.period,
        "stages": 2 if scenario.integrator == "rk4" else 1,
        "closed": scenario.loop == "closed",
        "waits": scenario.clock == "arm",
        "steps": scenario.steps,
        "parts": [
            {"first": part.first, "end": part.end, "twists": part.twists, "poses": _upper(part.poses)}
            for part in (parts_of(scenario) if planned else ())
        ],
        "changes": changes_of(plan.changes) if planned else [],
        "known": changes_of(plan.known) if planned else [],
        "asked": asked(task).ravel(),
        "rows": list(task.indices),
        "alongTool": along_tool(task),
        "fullRates": full_rates(scenario.arm.velocity_limits),
        "limits": [_finite(limit) for limit in np.max(np.abs(controller.velocity_limits), axis=1)],
        "kinds": _kinds(scenario),
        "words": {
            "health": [health.name.lower().replace("_", "-") for health in sorted(Health, key=int)],
            "status": [[bit, IN_WORDS[flag]] for flag in IN_WORDS if (bit := int(flag))],
            "invalid": STATUS["INVALID_INPUT"],
            "twist": list(TWIST.names),
        },
    }, notes


def arm_of(arm: Arm, tool: FloatArray) -> dict[str, Any]:
    """The arm's kinematics, for a drawing.

    Args:
        arm: the arm.
        tool: (4, 4) the task's point in the frame of the last joint [m].
    """
    return {
        "name": arm.name,
        "reach": min(arm.reach, 1e6),
        "joints": [
            {
                "name": name,
                "unit": unit,
                "lower": _finite(low),
                "upper": _finite(high),
            }
            for name, unit, (low, high) in zip(arm.joint_names, arm.joint_units, arm.position_limits, strict=True)
        ],
        "chain": [
            {
                "placement": moving.joint.placement.ravel().tolist(),
                "axis": list(map(float, moving.joint.axis)),
                "slides": moving.joint.kind == "prismatic",
                "joint": moving.leader,
                "factor": float(moving.factor),
                "offset": float(moving.offset),
            }
            for moving in arm.chain
        ],
        "tool": tool.ravel().tolist(),
    }


def setup_of(controller: Any) -> FloatArray:
    """A controller as numbers in a row (``control/setup.hpp``)."""
    return np.frombuffer(controller._get_setup())


def _playable(scenario: Scenario, notes: list[str]) -> bool:
    if scenario.steps > MOST_TICKS:
        notes.append(f"Its {scenario.steps:,} ticks are too many to be computed in the page (at most {MOST_TICKS:,}).")
        return False
    try:
        check_whole(scenario)
    except InputError:
        notes.append("Its motion is a Python function that the file does not hold; the page cannot compute it again.")
        return False
    return True


def _laws(scenario: Scenario) -> Iterable[dict[str, Any]]:
    """The scenario's law, then one of each other kind."""
    given = scenario.law
    assert given is not None
    others: list[Law] = [kind(weights=given.weights) for kind in LAWS if not isinstance(given, kind)]
    for law in (given, *others):
        label = law.word if law == type(law)(weights=law.weights) else f"{law.word}, as given"
        try:
            controller = replace(scenario, law=law, null_motion=None).controller()
        except InputError:
            continue  # it does not go with this task
        yield {"word": law.word, "label": label, "setup": setup_of(controller)}


def _null_motions(scenario: Scenario) -> Iterable[dict[str, Any]]:
    """The scenario's null motion, then others, as setups of which the null motion counts."""
    limits = full_rates(scenario.arm.velocity_limits)
    largest = NULL_RATE * float(np.median(limits)) or NULL_RATE
    choices: list[tuple[str, NullMotion | None]] = [
        ("none", None),
        ("away from singularities", Manipulability(gain=0.5, max_rate=largest)),
        ("towards tolerance of failures", Tolerance(gain=0.2, max_rate=largest)),
        ("back to the start posture", Posture(q=scenario.start, max_rate=largest)),
    ]
    if np.any(np.all(np.isfinite(scenario.arm.position_limits), axis=1)):
        choices.append(("towards the middle of the ranges", Centring(max_rate=largest)))
    own = scenario.null_motion
    callable_ = isinstance(own, Gradient) and callable(own.gradient)
    if isinstance(own, NullMotion) and not callable_:
        choices.insert(0, (f"{own.word}, as given", own))
    for label, motion in choices:
        controller = scenario.controller()
        try:
            controller.set_null_motion(motion)
        except InputError:
            continue  # it does not go with these weights
        yield {"label": label, "setup": setup_of(controller)}


def _kinds(scenario: Scenario) -> list[dict[str, Any]]:
    """The failures that a click makes: for each joint two numbers, and what is added to both of where it stands."""
    found = []
    for word, (made, meaning) in KINDS.items():
        numbers: list[Any] = []
        moves, health = 0.0, 0
        for joint in range(scenario.arm.n):
            try:
                kind, elsewhere = made(scenario, joint, 0.0), made(scenario, joint, 1.0)
            except InputError:  # a runaway without a limit to take a share of
                numbers.append(None)
                continue
            health, moves = int(kind.health), elsewhere.numbers[0] - kind.numbers[0]
            numbers.append(list(kind.numbers))
        if any(numbers):
            found.append({"word": word, "meaning": meaning, "health": health, "numbers": numbers, "moves": moves})
    return found


def changes_of(changes: Mapping[int, Sequence[Change]]) -> list[dict[str, Any]]:
    """Changes of faults by tick, in a row."""
    found = []
    for tick in sorted(changes):
        for joint, kind in changes[tick]:
            first, second = (0.0, 0.0) if kind is None else kind.numbers
            health = Health.HEALTHY if kind is None else kind.health
            found.append(
                {
                    "tick": tick,
                    "joint": joint,
                    "health": int(health),
                    "first": _number(first),
                    "second": _number(second),
                }
            )
    return found


def _upper(poses: FloatArray) -> FloatArray:
    """(K, 12) the first three rows of poses (K, 4, 4)."""
    return np.ascontiguousarray(poses[:, :3].reshape(len(poses), 12))


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _number(value: float) -> float | str:
    """A number that may be infinite, as JavaScript's Number() reads it."""
    return float(value) if math.isfinite(value) else "Infinity" if value > 0 else "-Infinity"
