"""The task that `stillreach inspect` judges an arm by, from options."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.task import Task

EXPECTED = "pose, position, orientation, or some of vx, vy, vz, wx, wy, wz separated by commas, e.g. vx,vy,wz"


def task_of(rows: str, frame: str) -> Task:
    """The task of ``"pose"``, ``"position"``, ``"orientation"`` or components separated by commas.

    Raises:
        InputError: an option is invalid.
    """
    from stillreach._labels import TWIST
    from stillreach.task import FRAMES, ROWS, Task

    if frame not in FRAMES:
        raise InputError("--frame", repr(frame), " or ".join(FRAMES))
    if rows in ROWS:
        return Task(rows=rows, frame=frame)
    parts = [part.strip() for part in rows.split(",")]
    if not set(parts) <= set(TWIST.names) or len(set(parts)) < len(parts):
        raise InputError("--rows", repr(rows), EXPECTED)
    return Task(rows=[name in parts for name in TWIST.names], frame=frame)


def lost_below(text: str | None) -> tuple[float, float]:
    """Speeds [m/s] and [rad/s] of ``"1mm,0.1deg"``; None: the default.

    Raises:
        InputError: the text is not that.
    """
    from stillreach._units import tolerances
    from stillreach.arm.dexterity import LEAST_SPEED, LEAST_TURN

    speed, turn = tolerances("--lost-below", text, per_second=True)
    if speed == 0.0 or turn == 0.0:
        raise InputError("--lost-below", repr(text), "speeds above 0, e.g. 1mm,0.1deg")
    return LEAST_SPEED if speed is None else speed, LEAST_TURN if turn is None else turn
