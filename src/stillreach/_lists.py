"""The forms of settings that hold several values: lists, tables by name, and one value for each joint."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from stillreach._forms import Form, Schema
from stillreach._messages import shown
from stillreach._reading import WRONG, Place, Reading
from stillreach.errors import InputError

MOST_JOINTS = 200

Check = tuple[Callable[[list[Any]], bool], str]
"""What the entries of a list are together, and that in words."""
NOT_ALL_ZERO: Check = (any, "numbers that are not all 0")
RISING: Check = (lambda times: all(later > earlier for earlier, later in pairwise(times)), "times that rise")
LOWER_FIRST: Check = (lambda bounds: bool(bounds[0] <= bounds[1]), "the lower one first")


class List(Form):
    """A list: of entries of one form, or of as many entries as there are forms."""

    types = (list,)

    def __init__(self, *forms: Form, least: int = 1, most: int = MOST_JOINTS, check: Check | None = None) -> None:
        self.forms, self.check, self.fixed = forms, check, len(forms) > 1
        self.least, self.most = (len(forms), len(forms)) if self.fixed else (least, most)
        self.number = f"{self.least}" if self.least == self.most else f"{self.least} to {self.most}"
        self.expected = f"a list of {self.number} entries"
        self.unit = ", ".join(dict.fromkeys(form.unit for form in forms if form.unit))

    def fits(self, value: Any) -> bool:
        """Whether it is a list, of lists where its entries are."""
        return super().fits(value) and any(isinstance(entry, list) for entry in value) <= isinstance(
            self.forms[0], List
        )

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """Entry by entry, so that a mistake in one does not hide one in another."""
        if not self.least <= len(value) <= self.most:
            return reading.wrong(place, shown(value), f"{self.number} entries")
        forms = self.forms if self.fixed else self.forms * len(value)
        entries = [forms[k].read(entry, (*place, k), reading) for k, entry in enumerate(value)]
        if any(entry is WRONG for entry in entries):
            return WRONG
        good = self.check is None or self.check[0](entries)
        return entries if good else reading.wrong(place, shown(value), self.check[1] if self.check else "")

    def schema(self, tables: Schema) -> Schema:
        """With the number of entries; where they have several forms, each may be any of them."""
        forms = {str(schema): schema for form in self.forms for schema in [form.schema(tables)]}
        items = next(iter(forms.values())) if len(forms) == 1 else {"anyOf": list(forms.values())}
        return {"type": "array", "items": items, "minItems": self.least, "maxItems": self.most}


class Named(Form):
    """A table of entries by names that the file chooses, and whatever takes the table checks.

    Args:
        entry: the form of each.
        names: what a name may be, as a regular expression.
        most: how many.
        expected: in words.
    """

    types = (dict,)

    def __init__(self, entry: Form, names: str = "", most: int = MOST_JOINTS, expected: str = "a table") -> None:
        self.entry, self.names, self.most, self.expected, self.unit = entry, names, most, expected, entry.unit

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """Entry by entry."""
        entries = {name: self.entry.read(entry, (*place, name), reading) for name, entry in value.items()}
        return WRONG if any(entry is WRONG for entry in entries.values()) else entries

    def spoken(self, text: str, argument: str, reading: Reading) -> Any:
        """``position=100+orientation=8``."""
        pairs = [pair.partition("=") for pair in re.split(r"\+(?=[a-z])", text)]
        if not all(equals for _, equals, _ in pairs):
            return text
        names = [name for name, _, _ in pairs]
        if len(set(names)) < len(names):
            raise InputError(argument, repr(text), "each name once")
        return {name: self.entry.spoken(entry, argument, reading) for name, _, entry in pairs}

    def schema(self, tables: Schema) -> Schema:
        """With the pattern of the names."""
        names = {"propertyNames": {"pattern": self.names}, "minProperties": 1} if self.names else {}
        return {
            "type": "object",
            "additionalProperties": self.entry.schema(tables),
            "maxProperties": self.most,
            **names,
        }


class PerJoint(Form):
    """One value a joint: a list, a table by name, or one for all where that is legal.

    Args:
        entry: the form of each.
        one_for_all: whether a single entry stands for all joints.
        others: attribute of the arm with the values of joints that a table does not name; zeros where empty.
    """

    types = (list, dict)

    def __init__(self, entry: Form, *, one_for_all: bool = False, others: str = "") -> None:
        self.entry, self.one_for_all, self.others, self.unit = entry, one_for_all, others, entry.unit
        self.forms = [*[entry] * one_for_all, List(entry), Named(entry)]
        one = f"{entry.expected}, " if one_for_all else ""
        self.expected = f"{one}a list, one for each joint, or a table by joint name"

    def fits(self, value: Any) -> bool:
        """Whether it is a list or table, or one entry for all."""
        return super().fits(value) or (self.one_for_all and self.entry.fits(value))

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """(n, ...) in SI units; None where the arm is unknown."""
        form = next((form for form in self.forms if form.fits(value)), self.forms[-2])
        entries = form.read(value, place, reading)
        if entries is WRONG or reading.arm is None:
            return entries if entries is WRONG else None
        arm, factors = reading.arm, reading.joint_factors()
        if isinstance(value, dict):
            index = {name: reading.joint_index((*place, name), name) for name in entries}
            if None in index.values():
                return WRONG
            numbers = np.array(getattr(arm, self.others)) if self.others else np.zeros(arm.n)
            for name, entry in entries.items():
                numbers[index[name]] = np.asarray(entry) * factors[index[name]]
            return numbers
        if form is not self.entry and len(entries) != arm.n:
            return reading.wrong(place, f"{len(entries)} entries", f"{arm.n}, one for each joint of {arm.name}")
        numbers = np.asarray([entries] * arm.n if form is self.entry else entries, dtype=float)
        return numbers * factors.reshape((-1, *(1,) * (numbers.ndim - 1)))

    def schema(self, tables: Schema) -> Schema:
        """Each of the ways."""
        return {"anyOf": [form.schema(tables) for form in self.forms]}
