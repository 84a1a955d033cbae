"""The values of a scenario file, of which only those without a mistake are given out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.follower import note_of
from stillreach.errors import InputError, Mistake, listing
from stillreach.simulation.scenario_file.document import Document, Place
from stillreach.simulation.scenario_file.units import Units
from stillreach.simulation.scenario_file.words import did_you_mean, shown, written

MOST = 100
"""Mistakes after which no more hints are looked for; after twice as many, the rest is not listed."""


class Reading:
    """What is known of a file so far, and everything that is wrong with it.

    Values are checked one by one, so that a mistake in one of them does not hide a mistake in another.

    Args:
        document: the file.
        mistakes: what is wrong with its form, with places.
        unchecked: places whose values nothing is known of; they are not given out.
    """

    def __init__(
        self, document: Document, mistakes: Iterable[tuple[Place, Mistake]], unchecked: Iterable[Place] = ()
    ) -> None:
        self.document = document
        self.mistakes: list[Mistake] = []
        self._wrong: set[Place] = set(unchecked)
        self._touched: set[Place] = set()
        for place, mistake in mistakes:
            self._note(place, mistake)
        self.units = Units.of({key: self.value("units", key) for key in ("length", "angle") if self.has("units", key)})

    def good(self, *place: str | int) -> bool:
        """Whether nothing is wrong at, above or below a place."""
        return place not in self._touched and not any(place[:k] in self._wrong for k in range(len(place) + 1))

    def value(self, *place: str | int) -> Any:
        """The value at a place; None where it is absent or something is wrong with it."""
        return self._raw(place) if self.good(*place) else None

    def has(self, *place: str | int) -> bool:
        """Whether there is a value without mistakes."""
        return self.value(*place) is not None

    def count(self, *place: str | int) -> int:
        """Number of entries of a list, whether or not they are right."""
        value: Any = self.document.content.get(str(place[0]))
        return len(value) if isinstance(value, list) else 0

    def given(self, *place: str | int) -> bool:
        """Whether there is anything at a place, right or wrong."""
        return self._raw(place) is not None

    def wrong(self, place: Place, got: str, expected: str, hint: str = "") -> None:
        """Something is wrong at a place."""
        self._note(place, Mistake(written(place), got, expected, hint, self.document.line(place)))

    def refused(self, place: Place, error: InputError) -> None:
        """A part of the package refused what came from a place; its argument names the key, perhaps one inside it."""
        key: Place = ()
        for part in error.argument.replace("]", "").replace("[", ".").split("."):
            key = (*key, int(part) if part.isdigit() else part)
        while len(key) > 1 and self._raw((*place, *key)) is None:
            key = key[:-1]
        got = "nothing" if error.got == "None" else error.got
        self.wrong((*place, *key), got, error.expected)

    def joint(self, place: Place, arm: Arm) -> str | None:
        """The joint named at a place; None, and a mistake, where the arm has no such joint."""
        name = self.value(*place)
        if name is None:
            return None
        if name not in arm.joint_names:
            self.unknown_joint(place, name, arm)
            return None
        return str(name)

    def unknown_joint(self, place: Place, name: str, arm: Arm) -> None:
        """A name that is no joint's."""
        expected = f"a joint of {arm.name}: {listing(arm.joint_names)}"
        hint = did_you_mean(name, arm.joint_names) if len(self.mistakes) < MOST else ""
        self.wrong(place, shown(name) + note_of(name, arm.followers), expected, hint)

    def joint_values(
        self, place: Place, arm: Arm, factors: FloatArray, others: FloatArray, *, one_for_all: bool = False
    ) -> FloatArray | None:
        """Numbers for the joints, from one for all, a list, or a table by name.

        Args:
            place: where they are.
            arm: whose joints.
            factors: (n,) what 1 stands for.
            others: (n, ...) values of the joints that a table does not name.
            one_for_all: whether what is no list of (rows of) numbers for each joint stands for all of them.

        Returns:
            Shaped as ``others``; None, and the mistakes, where they do not fit the arm.
        """
        value = self.value(*place)
        if value is None:
            return None
        scale = factors.reshape((-1, *(1,) * (others.ndim - 1)))
        if isinstance(value, dict):
            return self._by_name(place, value, arm, factors, others)
        if one_for_all and np.ndim(value) == others.ndim - 1:
            return np.broadcast_to(np.asarray(value, dtype=float), others.shape) * scale
        if len(value) != arm.n:
            self.wrong(place, f"{len(value)} entries", f"{arm.n}, one for each joint of {arm.name}")
            return None
        values: FloatArray = np.asarray(value, dtype=float) * scale
        return values

    def _by_name(
        self, place: Place, value: dict[str, Any], arm: Arm, factors: FloatArray, others: FloatArray
    ) -> FloatArray | None:
        values = others.copy()
        for name, number in value.items():
            if name in arm.joint_names:
                index = arm.joint_index(name)
                values[index] = np.asarray(number, dtype=float) * factors[index]
            else:
                self.unknown_joint((*place, name), name, arm)
        return values if self.good(*place) else None

    def _raw(self, place: Sequence[str | int]) -> Any:
        value: Any = self.document.content
        for part in place:
            try:
                value = value[part]
            except (KeyError, IndexError, TypeError):
                return None
        return value

    def _note(self, place: Place, mistake: Mistake) -> None:
        if len(self.mistakes) < 2 * MOST:
            self.mistakes.append(mistake)
        self._wrong.add(place)
        self._touched.update(place[:k] for k in range(len(place) + 1))
