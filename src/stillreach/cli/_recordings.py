"""The scenario of a command: a file, a ready one, or the motion of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli._complete import complete_robot
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm import Arm
    from stillreach.simulation import Scenario

STARTS = 8
"""Configurations among which the start of a motion of poses is chosen."""
PERIOD = 0.01
"""[s] of a recording's scenario, as of any other."""

RecordingOption = Annotated[
    str | None,
    typer.Option(
        "--recording",
        metavar="FILE",
        help="Instead of a scenario, the tool's motion in a rosbag2, an MCAP, CSV or Parquet file, or a run.",
    ),
]
RobotOption = Annotated[
    str | None,
    typer.Option(
        "--robot", metavar="ROBOT", help="Of the recording: URDF or MJCF file or name.", autocompletion=complete_robot
    ),
]
AngleOption = Annotated[
    str | None, typer.Option("--angle", metavar="UNIT", help="rad or deg: of a table that does not say its unit.")
]
TopicOption = Annotated[
    str | None,
    typer.Option("--topic", help="Of the joint states, where a bag has several; or of poses of the tool alone."),
]
EpisodeOption = Annotated[int | None, typer.Option("--episode", help="Of a dataset with several.")]
PeriodOption = Annotated[
    str | None,
    typer.Option("--period", metavar="TIME", help="Between two ticks on a recording, e.g. 4ms; by default 10ms."),
]


def recorded(
    recording: str,
    arm: Arm,
    *,
    angle: str | None = None,
    topic: str | None = None,
    episode: int | None = None,
    period: str | None = None,
) -> Scenario:
    """The scenario whose task is the tool's motion in a recording.

    Raises:
        InputError: if an option or the file is invalid.
    """
    from stillreach._units import quantity
    from stillreach.recordings import Recording

    step = PERIOD if period is None else quantity("--period", period, {"s": 1.0, "ms": 1e-3})
    if not Path(recording).exists():
        raise InputError("--recording", repr(recording), "a file or folder that exists")
    try:
        if topic is not None and _has_poses(Path(recording), topic):
            return _of_poses(recording, arm, topic, step)
        return Recording.load(recording, arm=arm, angle=angle, topic=topic, episode=episode).scenario(period=step)
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


def scenario_or_recording(
    scenario: str | None, recording: str | None, robot: str | None, tip: str | None, base: str | None, **options: Any
) -> tuple[str | Scenario, str]:
    """What a command simulates, and the name of its output folder.

    Raises:
        InputError: if neither or both came, or an option that does not go with what came.
    """
    from stillreach.cli._robots import load_arm

    if recording is None:
        for name, value in {"robot": robot, "tip": tip, "base": base, **options}.items():
            if value is not None:
                raise InputError(f"--{name}", repr(value), "a --recording with it; a scenario names its own robot")
        if scenario is None:
            raise InputError("SCENARIO", "nothing", "a scenario file, a ready one, or --recording with --robot")
        return scenario, scenario
    if scenario is not None:
        raise InputError("SCENARIO", f"{scenario!r} and a recording", "one of them")
    if robot is None:
        raise InputError("--robot", "nothing", "the robot of the recording: a URDF or MJCF file or a name")
    return recorded(recording, load_arm(robot, tip=tip, base=base, fixed={}), **options), recording
