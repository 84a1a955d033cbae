"""The scenario of a command: a file, a ready one, or the motion of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm import Arm
    from stillreach.cli import _options as option
    from stillreach.simulation import Scenario

STARTS = 8
"""Configurations among which the start of a motion of poses is chosen."""
PERIOD = 0.01
"""[s] of a recording's scenario, as of any other."""


def recorded(recording: str, robot: str, options: option.Recording) -> Scenario:
    """The scenario whose task is the tool's motion in a recording.

    Raises:
        InputError: if an option or the file is invalid.
    """
    from stillreach._units import quantity
    from stillreach.cli._robots import load_arm
    from stillreach.recordings import Recording

    arm = load_arm(robot, tip=options.tip, base=options.base, fixed={})
    step = PERIOD if options.period is None else quantity("--period", options.period, {"s": 1.0, "ms": 1e-3})
    topic = options.topic
    if not Path(recording).exists():
        raise InputError("--recording", repr(recording), "a file or folder that exists")
    try:
        if topic is not None and _has_poses(Path(recording), topic):
            return _of_poses(recording, arm, topic, step)
        read = Recording.load(recording, arm=arm, angle=options.angle, topic=topic, episode=options.episode)
        return read.scenario(period=step)
    except InputError as error:
        if error.argument not in ("angle", "topic", "episode", "period"):
            raise
        expected = error.expected.replace('angle="rad" or angle="deg"', "--angle rad or --angle deg")
        raise InputError(f"--{error.argument}", error.got, expected) from None


def _has_poses(file: Path, topic: str) -> bool:
    """Whether a topic of a bag has poses instead of joint states."""
    from stillreach.recordings.poses import KINDS
    from stillreach.recordings.rosbag import FILES, topic_kinds

    return (file.is_dir() or file.suffix in FILES) and topic_kinds(file).get(topic) in KINDS


def _of_poses(recording: str, arm: Arm, topic: str, period: float) -> Scenario:
    """The scenario whose task is a recorded motion of the tool alone, from the most dexterous start that was found."""
    import numpy as np

    from stillreach._text import printable
    from stillreach.recordings import Recording
    from stillreach.simulation import Scenario

    motion = Recording.tool_motion(recording, topic=topic)
    first = np.eye(4)
    assert motion.orientations is not None
    first[:3, :3], first[:3, 3] = motion.orientations[0], motion.points[0]
    found = arm.inverse(first, solutions=STARTS)
    if not found.reached:
        raise InputError("--recording", f"{recording!r}, whose first pose the arm does not reach", str(found))
    starts = found.q[np.isfinite(found.q).all(axis=-1)].reshape(-1, arm.n)
    start = starts[np.argmax(arm.manipulability(starts))]
    return Scenario(
        arm=arm, start=start, motion=motion, loop="closed", period=period, name=printable(Path(recording).stem)
    )


def refuse(options: Mapping[str, Any], expected: str) -> None:
    """Raises InputError for the first of the options that has a value."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"--{name}", repr(value), expected)


def scenario_or_recording(
    scenario: str | None, recording: str | None, robot: str | None, options: option.Recording
) -> tuple[str | Scenario, str]:
    """What a command simulates, and the name of its output folder.

    Raises:
        InputError: if neither or both came, or an option that does not go with what came.
    """
    if recording is None:
        refuse({"robot": robot, **options.given()}, "a --recording with it; a scenario names its own robot")
        if scenario is None:
            raise InputError("SCENARIO", "nothing", "a scenario file, a ready one, or --recording with --robot")
        return scenario, scenario
    if scenario is not None:
        raise InputError("SCENARIO", f"{scenario!r} and a recording", "one of them")
    if robot is None:
        raise InputError("--robot", "nothing", "the robot of the recording: a URDF or MJCF file or a name")
    return recorded(recording, robot, options), recording
