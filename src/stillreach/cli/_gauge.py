"""The task that `stillreach inspect` judges an arm by, from options."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.cli._locks import Gauge
    from stillreach.task import Task

EXPECTED = "pose, position, orientation, or some of vx, vy, vz, wx, wy, wz separated by commas, e.g. vx,vy,wz"


def gauge(rows: str, frame: str, least: str | None) -> Gauge:
    """What motion of the tool counts.

    Args:
        rows: ``"pose"``, ``"position"``, ``"orientation"`` or components separated by commas.
        frame: ``"base"`` or ``"tool"``.
        least: ``"1mm,0.1deg"``: a direction in which full rates give less a second is lost; None: the default.

    Raises:
        InputError: an option is invalid.
    """
    from stillreach._units import tolerances
    from stillreach.arm.dexterity import LEAST_SPEED, LEAST_TURN
    from stillreach.cli._locks import Gauge

    speed, turn = tolerances("--lost-below", least, per_second=True)
    if speed == 0.0 or turn == 0.0:
        raise InputError("--lost-below", repr(least), "speeds above 0, e.g. 1mm,0.1deg")
    return Gauge(_task(rows, frame), LEAST_SPEED if speed is None else speed, LEAST_TURN if turn is None else turn)


def _task(rows: str, frame: str) -> Task:
    from stillreach.cli._locks import COMPONENTS
    from stillreach.task import FRAMES, ROWS, Task

    if frame not in FRAMES:
        raise InputError("--frame", repr(frame), " or ".join(FRAMES))
    if rows in ROWS:
        return Task(rows=rows, frame=frame)
    parts = [part.strip() for part in rows.split(",")]
    if not set(parts) <= set(COMPONENTS) or len(set(parts)) < len(parts):
        raise InputError("--rows", repr(rows), EXPECTED)
    return Task(rows=[name in parts for name in COMPONENTS], frame=frame)
