"""What reading a setting takes beside its value: units, joints, folder, and a list for the mistakes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from stillreach import _messages
from stillreach._door import FloatArray
from stillreach._messages import listing, shown, written
from stillreach.arm import Arm
from stillreach.arm.follower import note_of
from stillreach.errors import InputError, Mistake

Place = tuple[str | int, ...]
"""Keys and indices that lead to a value: ``("faults", 1, "joint")``."""

WRONG: Any = object()
"""Stands for a value with a mistake."""
MOST = 100
"""Mistakes that are listed; of more, only their number is."""


class Reading:
    """Units and joints that values are read with, and every mistake so far.

    Args:
        folder: that other files are relative to.
        line: the line of a place, from 1 on, or None.
        content: the tables that are read.
    """

    def __init__(
        self,
        folder: Path = Path(),
        line: Callable[[Place], int | None] = lambda place: None,
        content: Any = None,
    ) -> None:
        self.folder, self.content = folder, content
        self.length, self.angle = 1.0, 1.0
        """[m], [rad] the units of numbers."""
        self.arm: Arm | None = None
        """Whose joints are named; None while it is unknown or wrong."""
        self.joint: int | None = None
        """The joint whose value is read."""
        self._line = line
        self._mistakes: list[Mistake] = []
        self._more = 0

    @property
    def mistakes(self) -> list[Mistake]:
        """What is wrong, in the order of the lines."""
        found = sorted(self._mistakes, key=lambda mistake: (mistake.line or 0, mistake.place))
        more = [Mistake("", f"{self._more} more mistakes", "none")] if self._more else []
        return found + more

    def wrong(self, place: Place, got: str, expected: str, hint: str = "") -> Any:
        """Records a mistake at a place; returns WRONG."""
        if len(self._mistakes) < MOST:
            self._mistakes.append(Mistake(written(place), got, expected, hint, self._line(place)))
        else:
            self._more += 1
        return WRONG

    def holds(self, place: Place) -> bool:
        """Whether there is a value at a place."""
        content = self.content
        for part in place:
            try:
                content = content[part]
            except (KeyError, IndexError, TypeError):
                return False
        return True

    def refused(self, place: Place, error: InputError) -> Any:
        """Records what a constructor refused; the argument names the key of the place, perhaps one inside it."""
        key: Place = ()
        for part in error.argument.replace("]", "").replace("[", ".").split("."):
            key = (*key, int(part) if part.isdigit() else part)
        while len(key) > 1 and not self.holds((*place, *key)):
            key = key[:-1]
        return self.wrong((*place, *key), error.got, error.expected)

    def raise_first(self, prefix: str) -> None:
        """InputError for the first mistake, if there is one; its argument is the place behind a prefix."""
        for wrong in self._mistakes:
            hint = f" ({wrong.hint})" if wrong.hint else ""
            raise InputError(f"{prefix}{wrong.place}", wrong.got, f"{wrong.expected}{hint}")

    def hint(self, word: Any, choices: Iterable[str]) -> str:
        """``did you mean 'elbow'?`` or nothing; nothing where there are many mistakes already."""
        return _messages.hint(word, choices) if len(self._mistakes) < MOST else ""

    def factor(self, unit: str) -> float:
        """What a number 1 of a unit such as ``"angle"`` or ``"joint/s"`` stands for [SI]."""
        kind = unit.partition("/")[0]
        if kind == "joint":
            return 1.0 if self.arm is None or self.joint is None else float(self.joint_factors()[self.joint])
        if kind == "arm":  # one number for joints of both kinds: lengths only where all joints are slides
            return self.length if self.arm is not None and np.all(np.asarray(self.arm.kinds) == 1) else self.angle
        return {"length": self.length, "angle": self.angle}.get(kind, 1.0)

    def joint_factors(self) -> FloatArray:
        """(n,) what a joint value of 1 stands for [rad, m]."""
        assert self.arm is not None
        return np.where(np.asarray(self.arm.kinds) == 1, self.length, self.angle)

    def joint_index(self, place: Place, name: Any) -> int | None:
        """The index of a joint; None where the arm is unknown, or, with a mistake, where it has no such joint."""
        if self.arm is None:
            return None
        if name in self.arm.joint_names:
            return self.arm.joint_names.index(name)
        names = self.arm.joint_names
        got = shown(name) + note_of(name, self.arm.followers)
        self.wrong(place, got, f"a joint of {self.arm.name}: {listing(names)}", self.hint(name, names))
        return None
