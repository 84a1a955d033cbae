"""The data of a task in a page: arm, controller, laws to choose from, commands and faults."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.dexterity import full_rates
from stillreach.arm.limits import sampling_range
from stillreach.errors import InputError
from stillreach.laws import LAWS, Law
from stillreach.null_motions import Centring, Gradient, GuaranteedSpeed, Manipulability, NullMotion, Posture, Tolerance
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
SAMPLES, NOTHING = 64, 1e-6
"""Configurations of a sample, and the share of the largest singular value below which one counts as 0."""
SIZE, SHORTEST, LONGEST, EASE = 0.1, 8.0, 60.0, 0.5
"""Of the page's own motions: size as a share of the reach, times of a round [s], the share of the arm's speed."""
NULL_RATE = 0.3
"""Largest rate of a page's own null motions, as a share of the median velocity limit."""


def task_of(scenario: Scenario, *, planned: bool) -> tuple[dict[str, Any], list[str]]:
    """The data of a scenario for ``pack``, and notes about what the page does not compute as a run does.

    Args:
        scenario: the scenario.
        planned: whether the page plays its motion and faults; else the arm stands at the start.
    """
    task, plan, own = scenario.task, scenario.schedule, scenario.null_motion
    assert task is not None
    planned, notes = _playable(scenario) if planned else (False, [])
    controller = scenario.controller()
    if _is_function(own):
        notes.append("The page computes without the null motion, which is a Python function.")
        controller.set_null_motion(None)
    plant = scenario.plant if isinstance(scenario.plant, KinematicPlant) else KinematicPlant()
    delays = any(fault.known_after for fault in scenario.faults)
    return {
        "title": scenario.title,
        "arm": kinematics_of(scenario),
        "setup": setup_of(controller),
        "laws": list(_laws(scenario)),
        "nullMotions": list(_null_motions(scenario)),
        "plant": plant.settings(scenario.period),
        "hasPlant": not plant.exact or delays,
        "noise": plant.errors(scenario.steps + 1, scenario.arm.n) if planned else None,
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
        "never": _never(scenario),
        "pace": _pace(scenario),
        "asked": asked(task).ravel(),
        "rows": list(task.indices),
        "alongTool": along_tool(task),
        "fullRates": full_rates(scenario.arm.velocity_limits),
        "limits": [_finite(limit) for limit in np.max(np.abs(controller.velocity_limits), axis=1)],
        "kinds": _kinds(scenario),
        "words": {
            "health": [health.name.lower().replace("_", "-") for health in sorted(Health, key=int)],
            "status": [[bit, IN_WORDS[flag]] for flag in IN_WORDS if (bit := int(flag))],
        },
    }, notes


def _never(scenario: Scenario) -> int:
    """Directions of the task that the arm has nowhere, because it has too few joints or they do not serve them."""
    arm, task = scenario.arm, scenario.task
    assert task is not None
    low, high = sampling_range(arm.kinds, *arm.position_limits.T)
    q = low + np.random.default_rng(0).uniform(0.2, 0.8, (SAMPLES, arm.n)) * (high - low)
    sigma = arm.singular_values(q, task)
    return len(task.indices) - int(np.max(np.sum(sigma > NOTHING * np.max(sigma), axis=1)))


def _pace(scenario: Scenario) -> dict[str, float]:
    """Size, as a share of the reach, and time [s] of a round of the page's own motions that the arm can follow."""
    arm = scenario.arm
    columns = arm.jacobian(scenario.start)[:3] * full_rates(arm.velocity_limits)
    sigma = np.linalg.svd(columns, compute_uv=False)
    moving = sigma[sigma > 0.01 * sigma[0]] if sigma[0] > 0.0 else np.ones(1)
    round_of = 2.0 * math.pi * min(arm.reach, 1e6) / (EASE * float(moving[-1]))  # [s] of a circle as large as the reach
    size = min(SIZE, max(0.01, math.floor(100.0 * LONGEST / round_of) / 100.0))
    return {"size": size, "seconds": min(max(SHORTEST, math.ceil(2.0 * size * round_of) / 2.0), LONGEST)}


def kinematics_of(scenario: Scenario) -> dict[str, Any]:
    """The arm with the task's tool, for a drawing."""
    arm, task = scenario.arm, scenario.task
    tool = arm.tool if task is None or task.tool is None else arm.tool @ task.tool
    return {
        "name": arm.name,
        "reach": min(arm.reach, 1e6),
        "joints": [{"name": name, "unit": unit} for name, unit in zip(arm.joint_names, arm.joint_units, strict=True)],
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


def _playable(scenario: Scenario) -> tuple[bool, list[str]]:
    """Whether the page can compute a motion, and how that differs from a run."""
    if scenario.steps > MOST_TICKS:
        return False, [f"The page computes at most {MOST_TICKS:,} ticks; this task has {scenario.steps:,}."]
    try:
        check_whole(scenario)
    except InputError:
        return False, ["The motion is a Python function, which the file does not contain; the page cannot compute it."]
    notes = []
    if not isinstance(scenario.plant, KinematicPlant):
        notes.append("The page computes an arm without inertia; the recorded motion is one of an arm with inertia.")
    if scenario.clock == "arm":
        notes.append("The motion waits for the arm; the page rounds its commands to the nearest tick.")
    return True, notes


def _is_function(motion: Any) -> bool:
    return isinstance(motion, Gradient) and callable(motion.gradient)


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
        ("towards speed after a failure", GuaranteedSpeed(gain=0.2, max_rate=largest)),
        ("back to the start posture", Posture(q=scenario.start, max_rate=largest)),
    ]
    if np.any(np.all(np.isfinite(scenario.arm.position_limits), axis=1)):
        choices.append(("towards the middle of the ranges", Centring(max_rate=largest)))
    own = scenario.null_motion
    if isinstance(own, NullMotion) and not _is_function(own):
        choices.insert(0, (f"{own.word}, as given", own))
    for label, motion in choices:
        controller = scenario.controller()
        try:
            controller.set_null_motion(motion)
        except InputError:
            continue  # it does not go with this arm, task or weights
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
                    "first": number(first),
                    "second": number(second),
                }
            )
    return found


def _upper(poses: FloatArray) -> FloatArray:
    """(K, 12) the first three rows of poses (K, 4, 4)."""
    return np.ascontiguousarray(poses[:, :3].reshape(len(poses), 12))


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def number(value: float) -> float | str:
    """A number that may be infinite, as JavaScript's Number() reads it."""
    return float(value) if math.isfinite(value) else "Infinity" if value > 0 else "-Infinity"
