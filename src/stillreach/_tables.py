"""Tables of settings in files: their keys, and one of several tables by its kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from stillreach._forms import Form, Schema
from stillreach._kinds import REQUIRED, Key, Kind
from stillreach._messages import listed, nearest, one_of, shown
from stillreach._reading import WRONG, Place, Reading
from stillreach.errors import InputError

TAG = "kind"
COMPARED = 100
"""Keys of a table of unknown kind that are looked at."""


class Table(Form):
    """A table without other keys.

    Args:
        name: of its schema.
        text: what it is.
        keys: its settings.
        build: makes something of their values, and raises InputError where they do not fit each other.
        tag: the value of its key ``kind``, if it has one.
    """

    types = (dict,)
    expected = "a table"

    def __init__(
        self,
        name: str,
        text: str,
        keys: Mapping[str, Key],
        build: Callable[[dict[str, Any], Reading], Any] = lambda values, reading: values,
        tag: str = "",
    ) -> None:
        self.name, self.text, self.keys, self.build, self.tag = name, text, dict(keys), build, tag

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """What ``build`` makes of its values."""
        values = self.values(value, place, reading)
        if values is WRONG:
            return WRONG
        try:
            return self.build(values, reading)
        except InputError as error:
            return reading.refused(place, error)

    def values(self, value: dict[str, Any], place: Place, reading: Reading) -> Any:
        """The values by key; WRONG after recording everything that is wrong with them."""
        reading.joint = None
        known = [TAG] * bool(self.tag) + list(self.keys)
        found = {}
        for name in [name for name in value if name not in known]:
            got = f"unknown key {shown(name)}"
            found[name] = reading.wrong((*place, name), got, f"one of {listed(known)}", reading.hint(name, known))
        for name, own in self.keys.items():
            if name in value:
                found[name] = own.form.read(value[name], (*place, name), reading)
            elif own.default is REQUIRED:
                found[name] = reading.wrong((*place, name), "missing key", uncapitalised(own.meaning))
        reading.joint = None
        return WRONG if any(entry is WRONG for entry in found.values()) else found

    def schema(self, tables: Schema) -> Schema:
        """A reference to its definition."""
        if self.name not in tables:
            tables[self.name] = {}  # its place, before those of the tables in it
            tables[self.name].update(self.definition(tables))
        return {"$ref": f"#/definitions/{self.name}"}

    def definition(self, tables: Schema) -> Schema:
        """The schema itself."""
        tag = {TAG: {"const": self.tag}} if self.tag else {}
        required = [*tag, *(name for name, own in self.keys.items() if own.default is REQUIRED)]
        properties = {**tag, **{name: own.schema(tables) for name, own in self.keys.items()}}
        return {
            "description": self.text,
            "type": "object",
            "properties": properties,
            "additionalProperties": False,
            **({"required": required} if required else {}),
        }


class Choice(Form):
    """One of several tables, by the word of their key ``kind``."""

    types = (dict,)
    expected = "a table"

    def __init__(self, tables: Mapping[str, Table]) -> None:
        self.tables = dict(tables)
        first, *others = self.tables.values()
        shared = {name: own for name, own in first.keys.items() if all(own == other.keys.get(name) for other in others)}
        self.shared = Table("", "", shared)

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As the table that it is."""
        word = value.get(TAG)
        if isinstance(word, str) and word in self.tables:
            return self.tables[word].read(value, place, reading)
        misspelt = next((name for name in list(value)[:COMPARED] if nearest(name, [TAG])), None)
        if TAG not in value and misspelt is not None:
            got, hint = f"unknown key {shown(misspelt)}", reading.hint(misspelt, [TAG])
            reading.wrong((*place, misspelt), got, repr(TAG), hint)
            self.taken(renamed(value, misspelt, TAG), place, reading)
        else:
            got = shown(word) if TAG in value else "missing key"
            reading.wrong((*place, TAG), got, one_of(self.tables), reading.hint(word, self.tables))
            self._others(value, place, reading)
        return WRONG

    def _others(self, value: dict[str, Any], place: Place, reading: Reading) -> None:
        """What else is wrong with a table of unknown kind, as if it were the one that was meant, or any."""
        near = nearest(value.get(TAG), self.tables)
        if near:
            self.tables[near].values(value, place, reading)
        else:
            known = {name: entry for name, entry in value.items() if name in self.shared.keys}
            self.shared.values(known, place, reading)

    def schema(self, tables: Schema) -> Schema:
        """Exactly one of them."""
        return {"oneOf": [table.schema(tables) for table in self.tables.values()]}


def renamed(table: Mapping[str, Any], wrong: str, right: str) -> dict[str, Any]:
    """The table with another name for a key."""
    return {right if name == wrong else name: entry for name, entry in table.items()}


def tables_of(kinds: Iterable[type[Kind]]) -> dict[str, Table]:
    """A table for each kind that a file can hold, by word."""
    return {
        kind.word: Table(kind.__name__, about(kind), kind.keys(), kind.read, kind.word)
        for kind in kinds
        if kind.in_files
    }


def about(cls: type) -> str:
    """The first paragraph of a class's docstring, in one line."""
    return " ".join((cls.__doc__ or "").partition("\n\n")[0].split())


def uncapitalised(text: str) -> str:
    """The text with a small first letter, unless that is a word of its own."""
    return text[:1].lower() + text[1:] if text[1:2].islower() else text
