"""Kinds: the members of a closed set, such as laws or faults, each with its word and its settings.

A class of a kind is a dataclass whose fields carry their keys (``field(metadata=key(...))``). Its defaults are those of
its constructor.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any, ClassVar, Self, TypeVar

from stillreach._forms import Form, Integer, Number, Schema
from stillreach._reading import Reading

REQUIRED: Any = inspect.Parameter.empty


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


@cache
def keys_of(cls: Any) -> dict[str, Key]:
    """The settings of a dataclass by name, with the defaults of its constructor; not to be changed."""
    parameters = inspect.signature(cls).parameters
    given = [field for field in fields(cls) if "key" in field.metadata and field.name in parameters]
    return {field.name: replace(field.metadata["key"], default=parameters[field.name].default) for field in given}


def keys_for(call: Callable[..., Any], **settings: tuple[Form, str]) -> dict[str, Key]:
    """Settings of something that does not carry its keys, with the defaults of its arguments; others are required."""
    parameters = inspect.signature(call).parameters
    return {
        name: Key(form, text, parameters[name].default if name in parameters else REQUIRED)
        for name, (form, text) in settings.items()
    }


class Kind:
    """Base of the classes of a set of kinds."""

    word: ClassVar[str]
    """What files and the command line call it."""
    in_files: ClassVar[bool] = True
    """Whether a file can hold it."""

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Its settings in a file, by name."""
        own: Any = cls
        return keys_of(own)

    def check_numbers(self) -> None:
        """Raises InputError for a setting that is not a number of its form."""
        for name, own in self.keys().items():
            if isinstance(own.form, Number | Integer):
                object.__setattr__(self, name, own.form.checked(name, getattr(self, name)))

    @classmethod
    def read(cls, values: dict[str, Any], reading: Reading) -> Self:
        """From the values of these settings; InputError where they do not fit each other."""
        return cls(**values)


Member = TypeVar("Member", bound=Kind)


def by_word(kinds: Iterable[type[Member]]) -> dict[str, type[Member]]:
    """Kinds by word."""
    return {kind.word: kind for kind in kinds}
