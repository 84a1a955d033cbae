"""A recorder for a loop of one's own: a rosbag2 of what its controller does."""

from __future__ import annotations

import atexit
import math
import os
import threading
import warnings
import weakref
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from stillreach import _door
from stillreach._core import RecorderCore
from stillreach._door import FloatArray
from stillreach._files import file_name
from stillreach.control import Controller
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation.progress import Progress

if TYPE_CHECKING:
    from stillreach.bags.recover import Recovered

CHUNK, EVERY = 128, 0.1
"""Ticks of a chunk at most, and time [s] between two looks for new ones."""
MOST_BYTES = 10**9
"""Of memory for ticks that wait."""
TOPICS = ("/joint_states", "/joint_commands", "/tool_pose", "/target_pose", "/tool_command", "/tf")


class Recorder(RecorderCore):
    """Writes what a controller does into a rosbag2, and never holds its loop.

    ``add`` copies a tick into memory, in less than a microsecond; a thread writes it into the file within 0.2 s. A
    process that is killed leaves a file without an end, of which ``recover`` makes a whole one. Use it in a ``with``
    block, or call ``close``. In a forked process ticks are dropped.

    Args:
        path: the new folder, e.g. ``drive.rosbag2``.
        controller: whose ticks are recorded.
        seconds: [s] of ticks that memory holds where the disk does not keep up; later ones are dropped and counted.

    Raises:
        InputError: if an argument is invalid, or there is something of that name.
        MissingExtraError: if rosbags is not installed (extra ``recordings``).
        OSError: if the folder cannot be made.
    """

    def __init__(self, path: str | os.PathLike[str], controller: Controller, *, seconds: float = 10.0) -> None:
        bag, messages = _extra("a Recorder")
        if not isinstance(controller, Controller):
            raise InputError("controller", _door.describe(controller), "a Controller")
        wanted = _door.positive("seconds", seconds) / controller.period
        most = MOST_BYTES // (8 * (3 * controller.arm.n + 32))
        if wanted > most:
            raise InputError(
                "seconds", f"{seconds:g}", f"at most {most * controller.period:.3g}, which are 1 GB of memory"
            )
        name = file_name("path", path)
        if not name:
            raise InputError("path", "''", "a new folder, by its name")
        folder = Path(name).absolute()  # also for a program that changes its folder
        if folder.exists():
            raise InputError("path", f"{folder.name!r}, which exists", "a new folder")
        super().__init__(controller, max(math.ceil(wanted), CHUNK))
        self._bag, self._placed = bag.Bag(folder, controller.arm, TOPICS), messages.placed
        self._folder, self._period, self._name = folder, controller.period, controller.arm.name
        self._n, self._written = controller.arm.n, 0
        self._error: BaseException | None = None
        self._closed = False
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stillreach recorder", daemon=True)
        self._thread.start()
        atexit.register(self.close)
        _OPEN.add(self)

    @property
    def written(self) -> int:
        """How many ticks are in the file."""
        return self._written

    @property
    def bytes_per_hour(self) -> float:
        """[bytes] that an hour of ticks takes."""
        return float(3600.0 / self._period * self._bag.tick_bytes)

    def close(self) -> None:
        """Writes what is left and completes the file. Later ticks are dropped.

        Raises:
            OSError: if the file could not be written.
        """
        self._end()
        self._stop.set()
        self._thread.join()
        if self._closed:
            return
        self._closed = True
        atexit.unregister(self.close)
        if self._error is not None:
            raise self._told(self._error) from self._error
        if self.dropped:
            text = f"{self.dropped} of {self.dropped + self._written} ticks were not recorded: the file did not keep up"
            warnings.warn(text, RuntimeWarning, stacklevel=2)

    def _told(self, error: BaseException) -> BaseException:
        """The error with the file, and what to do."""
        text = (
            f"the recording ends after {self._written} ticks; `stillreach convert --recover` makes a whole bag of them"
        )
        if isinstance(error, OSError) and error.errno:
            return OSError(error.errno, f"{error.strerror}: {text}", str(self._folder))
        error.add_note(f"{self._folder}: {text}")
        return error

    @staticmethod
    def recover(path: str | os.PathLike[str], to: str | os.PathLike[str]) -> Recovered:
        """Makes a whole rosbag2 of one that a crash left without its end, also of other recorders.

        Args:
            path: an MCAP file, or the folder of one.
            to: the new folder.

        Returns:
            Its number of messages, their time [s], and how many bytes were not whole.

        Raises:
            InputError: if it is no MCAP file, has no whole chunk of messages, or ``to`` exists.
            MissingExtraError: if rosbags is not installed (extra ``recordings``).
            OSError: if a file cannot be read or written.
        """
        _extra("recovering a bag")
        from stillreach.bags.recover import recover

        source, target = Path(file_name("path", path)), Path(file_name("to", to))
        with Progress("recovering", 1000, None) as bar:
            return recover(source, target, lambda read, size: bar.update(1000 * read // max(size, 1)))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = f"failed ({self._error})" if self._error else f"{self.bytes_per_hour / 1e9:.2g} GB an hour"
        return f"<Recorder of {self._name}: {self._written} ticks, {self.dropped} dropped, {state}>"

    def _run(self) -> None:
        """The thread that writes."""
        rows = np.empty((CHUNK, self._width))
        try:
            with self._bag:
                while not self._stop.wait(EVERY):
                    self._drain(rows)
                self._drain(rows)
        except BaseException as error:  # the loop goes on; close() raises it
            self._end()
            self._error = error

    def _drain(self, rows: FloatArray) -> None:
        """Writes all ticks that are there."""
        n, placed = self._n, self._placed
        while count := self._take(rows):
            parts = np.split(rows[:count], np.cumsum([1, n, n, 6, 12, 12, n]), axis=1)
            stamps, q, rates, command, pose, target, health, status = parts
            with np.errstate(invalid="ignore"):  # a tick without a pose or a target has NaN there
                here, there = (placed(T[:, :9].reshape(-1, 3, 3).swapaxes(1, 2), T[:, 9:]) for T in (pose, target))
            known = health.astype(np.int8)
            numbers = dict(zip(TOPICS, (q, rates, here, there, command, here), strict=True))
            times = np.ascontiguousarray(stamps[:, 0]).view(np.int64)
            self._bag.add(times, numbers, known, known, status[:, 0].astype(np.int32))
            self._written += count


_OPEN: weakref.WeakSet[Recorder] = weakref.WeakSet()


def _forked() -> None:
    """In a forked process, where no thread writes: its ticks are dropped, and the file is the parent's."""
    for recorder in list(_OPEN):
        recorder._end()
        recorder._closed = True


os.register_at_fork(after_in_child=_forked)


def _extra(what: str) -> tuple[Any, Any]:
    """The modules that write bags."""
    try:
        from stillreach.bags import bag, messages
    except ImportError as error:
        raise MissingExtraError("recordings", what) from error
    return bag, messages
