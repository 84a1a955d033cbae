"""Kinds: the members of a closed set, such as laws or faults, each with its word and its settings; tables of settings.

A class of a kind is a dataclass whose fields carry their keys (``field(metadata=key(...))``). Its defaults are those of
its constructor.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self, TypeVar

from stillreach._forms import Form, Schema
from stillreach._messages import listed, nearest, one_of, shown
from stillreach._reading import WRONG, Place, Reading
from stillreach.errors import InputError

REQUIRED: Any = inspect.Parameter.empty
TAG = "kind"
COMPARED = 100
"""Keys of a table of unknown kind that are looked at."""


@dataclass(frozen=True)
class Key:
    """A setting: its form, its meaning without unit, and its default."""

    form: Form
    text: str
    default: Any = REQUIRED

    @property
    def meaning(self) -> str:
        """With its unit."""
        return f"{self.text} [{self.form.unit}]" if self.form.unit else self.text

    def schema(self, tables: Schema) -> Schema:
        """The form's, with meaning and default. Draft 7 ignores what stands beside a reference."""
        form = self.form.schema(tables)
        scaled = (
            "angle" in self.form.unit or "length" in self.form.unit
        )  # the file's units are not those of the default
        plain = isinstance(self.default, str | int | float) and self.form.fits(self.default) and not scaled
        default = {"default": self.default} if plain else {}
        return {"description": f"{self.meaning}.", **default, **({"allOf": [form]} if "$ref" in form else form)}


def key(form: Form, text: str) -> dict[str, Key]:
    """Metadata of a dataclass field that is a setting."""
    return {"key": Key(form, text)}


def keys_of(cls: Any) -> dict[str, Key]:
    """The settings of a dataclass by name, with the defaults of its constructor."""
    parameters = inspect.signature(cls).parameters
    given = [field for field in fields(cls) if "key" in field.metadata and field.name in parameters]
    return {field.name: replace(field.metadata["key"], default=parameters[field.name].default) for field in given}


class Kind:
    """Base of the classes of a set of kinds."""

    word: ClassVar[str]
    """What files and the command line call it."""
    in_files: ClassVar[bool] = True
    """Whether a file can hold it."""

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Its settings in a file, by name."""
        return keys_of(cls)

    @classmethod
    def read(cls, values: dict[str, Any], reading: Reading) -> Self:
        """From the values of these settings; InputError where they do not fit each other."""
        return cls(**values)


Member = TypeVar("Member", bound=Kind)


def by_word(kinds: Iterable[type[Member]]) -> dict[str, type[Member]]:
    """Kinds by word."""
    return {kind.word: kind for kind in kinds}


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
    """One of several tables: by the word of their key ``kind``, or, where they have none, by a key that each alone has.

    Args:
        tables: by that word or key.
    """

    types = (dict,)
    expected = "a table"

    def __init__(self, tables: Mapping[str, Table]) -> None:
        self.tables = dict(tables)
        self.tagged = all(table.tag for table in self.tables.values())
        first, *others = self.tables.values()
        shared = {name: own for name, own in first.keys.items() if all(own == other.keys.get(name) for other in others)}
        self.shared = Table("", "", shared)

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As the table that it is."""
        word = value.get(TAG) if self.tagged else next((name for name in self.tables if name in value), None)
        if isinstance(word, str) and word in self.tables:
            return self.tables[word].read(value, place, reading)
        return self._of_kind(value, place, reading) if self.tagged else self._of_key(value, place, reading)

    def _of_kind(self, value: dict[str, Any], place: Place, reading: Reading) -> Any:
        """Unknown: what else is wrong with it, as if it were the kind that was meant, or any."""
        misspelt = next((name for name in list(value)[:COMPARED] if nearest(name, [TAG])), None)
        if TAG not in value and misspelt is not None:
            reading.wrong(
                (*place, misspelt), f"unknown key {shown(misspelt)}", repr(TAG), reading.hint(misspelt, [TAG])
            )
            self.taken({TAG if name == misspelt else name: entry for name, entry in value.items()}, place, reading)
            return WRONG
        got = shown(value[TAG]) if TAG in value else "missing key"
        reading.wrong((*place, TAG), got, one_of(self.tables), reading.hint(value.get(TAG), self.tables))
        near = nearest(value.get(TAG), self.tables)
        if near:
            self.tables[near].values(value, place, reading)
        else:
            known = {name: entry for name, entry in value.items() if name in self.shared.keys}
            self.shared.values(known, place, reading)
        return WRONG

    def _of_key(self, value: dict[str, Any], place: Place, reading: Reading) -> Any:
        """Likewise."""
        got = f"the keys {listed(value)}" if value else "an empty table"
        meant = [(name, near) for name in list(value)[:COMPARED] if (near := nearest(name, self.tables))]
        reading.wrong(
            place, got, f"one of the keys {', '.join(self.tables)}", f"did you mean {meant[0][1]!r}?" if meant else ""
        )
        for wrong, near in meant[:1]:
            renamed = {near if name == wrong else name: entry for name, entry in value.items()}
            self.tables[near].values(renamed, place, reading)
        return WRONG

    def schema(self, tables: Schema) -> Schema:
        """Exactly one of them."""
        return {"oneOf": [table.schema(tables) for table in self.tables.values()]}


def tables_of(kinds: Iterable[type[Kind]]) -> dict[str, Table]:
    """A table for each kind that a file can hold, by word."""
    return {
        kind.word: Table(kind.__name__, about(kind), kind.keys(), kind.read, kind.word)
        for kind in kinds
        if kind.in_files
    }


def uncapitalised(text: str) -> str:
    """The text with a small first letter, unless that is a word of its own."""
    return text[:1].lower() + text[1:] if text[1:2].islower() else text


def about(cls: type) -> str:
    """The first paragraph of a class's docstring, in one line."""
    return " ".join((cls.__doc__ or "").partition("\n\n")[0].split())


def keys_for(call: Callable[..., Any], **settings: tuple[Form, str]) -> dict[str, Key]:
    """Settings of something that does not carry its keys, with the defaults of its arguments; others are required."""
    parameters = inspect.signature(call).parameters
    return {
        name: Key(form, text, parameters[name].default if name in parameters else REQUIRED)
        for name, (form, text) in settings.items()
    }
