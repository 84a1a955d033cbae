"""A progress bar for long computations."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from stillreach._text import printable

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

PATIENCE = 1.0
"""Seconds after which a bar is shown."""


class Progress:
    """Shows a bar on standard error during a long computation.

    Args:
        label: text before the bar.
        total: the final count.
        show: True: from the start; False: never; None: on a terminal after a second.
    """

    def __init__(self, label: str, total: int, show: bool | None) -> None:
        self._label, self._total = label, total
        self._wanted = _there() and (sys.stderr.isatty() if show is None else show)
        self._from = time.monotonic() + (0.0 if show else PATIENCE)
        self._bar: Bar | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def update(self, done: int) -> None:
        """Updates the count."""
        if not self._wanted or time.monotonic() < self._from:
            return
        if self._bar is None:
            self._bar = self._started()
        self._bar.update(self._bar.task_ids[0], completed=done)

    def _started(self) -> Bar:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(),
        )
        console = Console(stderr=True)
        bar = Bar(*columns, console=console, transient=console.is_terminal)
        bar.add_task(printable(self._label), total=self._total)
        bar.start()
        return bar


def _there() -> bool:
    """Whether standard error exists: it is missing in a service, and a program may close it."""
    return sys.stderr is not None and not sys.stderr.closed
