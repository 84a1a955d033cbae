"""What pydantic found wrong, in the words of this package."""

from __future__ import annotations

import typing
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from stillreach.errors import Mistake
from stillreach.simulate.scenario_file.document import Document, Place
from stillreach.simulate.scenario_file.schema import CHOICES, ROBOTS, ScenarioTable, Table

EXPECTED = {
    "float_type": "a number",
    "int_type": "an integer",
    "bool_type": "true or false",
    "string_type": "a text",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "finite_number": "a finite number",
    "greater_than": "a number above {gt:g}",
    "greater_than_equal": "a number of at least {ge:g}",
    "less_than": "a number below {lt:g}",
    "less_than_equal": "a number of at most {le:g}",
    "too_short": "at least {min_length} entries",
    "too_long": "at most {max_length} entries",
    "string_too_short": "a text, not empty",
    "string_too_long": "at most {max_length} letters",
    "literal_error": "{expected}",
}
SHOWN = 60
"""Letters of a value in a message."""

TABLES: dict[str, type[Table]] = {f"<{kind}>": table for kinds in CHOICES.values() for kind, table in kinds.items()} | {
    f"<{key} robot>": table for key, table in ROBOTS.items()
}


def written(place: Place) -> str:
    """A place as a reader writes it: ``faults[1].joint``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text if len(text) <= 2 * SHOWN else f"{text[: 2 * SHOWN]}…"


def shown(value: Any) -> str:
    """What came, short."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table" if value else "an empty table"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, int) and abs(value) >= 10**20:
        return "a huge integer"
    text = repr(value) if isinstance(value, str | int | float) else str(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}…"


def did_you_mean(value: Any, choices: Iterable[str]) -> str:
    """A hint where one of the choices is nearly what came, else nothing."""
    if not isinstance(value, str) or len(value) > SHOWN:
        return ""
    names = {choice.lower(): choice for choice in choices if len(choice) <= SHOWN}
    near = get_close_matches(value.lower().replace("_", "-"), names, n=1) or get_close_matches(
        value.lower(), names, n=1
    )
    return f"did you mean {names[near[0]]!r}?" if near else ""


def listed(choices: Iterable[str], most: int = 40) -> str:
    """One of the choices, in words."""
    names = list(choices)
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(name if len(name) <= SHOWN else f"{name[:SHOWN]}…" for name in names[:most]) + more


def form_mistakes(document: Document) -> list[tuple[Place, Mistake]]:
    """What is wrong with the form of a file, each with its place."""
    try:
        ScenarioTable.model_validate(document.content)
    except ValidationError as error:
        return [_mistake(document, entry) for entry in error.errors(include_url=False)]
    return []


def _mistake(document: Document, error: ErrorDetails) -> tuple[Place, Mistake]:
    place = tuple(part for part in error["loc"] if not (isinstance(part, str) and part[:1] + part[-1:] == "<>"))
    if place and place[-1] == "[key]":
        place = place[:-1]
    kind, value, hint = error["type"], error["input"], ""
    got = shown(value)
    if kind == "missing":
        got, expected = "nothing", f"this key: {_meaning(error['loc'])}"
    elif kind == "extra_forbidden":
        keys = list(_table_at(error["loc"]).model_fields)
        got, expected = f"an unknown key {shown(place[-1])}", f"one of {listed(keys)}"
        hint = did_you_mean(place[-1], keys)
    elif kind in ("union_tag_invalid", "union_tag_not_found"):
        place, got, expected, hint = _no_kind(place, value)
    elif kind in EXPECTED:
        context = error.get("ctx", {})
        expected = EXPECTED[kind].format_map(context)
        if kind == "literal_error":
            choices = [choice.strip(" '") for choice in expected.replace(" or ", ", ").split(",")]
            hint = did_you_mean(value, choices)
            expected = expected if len(choices) == 1 else f"one of {', '.join(map(repr, choices))}"
        elif "{" not in EXPECTED[kind] and isinstance(value, str) and kind == "float_type":
            hint = "a number has no quotes" if _is_number(value) else ""
    else:
        expected = error["msg"]
    return place, Mistake(written(place), got, expected, hint, document.line(place))


def _no_kind(place: Place, value: Any) -> tuple[Place, str, str, str]:
    """A table that is none of the kinds there are: place, got, expected, hint."""
    if not isinstance(value, dict):
        return place, shown(value), "a table", ""
    kinds = CHOICES.get(str(place[0]))
    if kinds is None:  # the robot, which has no kind but a key of its own
        hints = [did_you_mean(key, ROBOTS) for key in value]
        expected = f"one of the keys {', '.join(ROBOTS)}"
        return (
            place,
            f"the keys {listed(value)}" if value else "an empty table",
            expected,
            next(filter(None, hints), ""),
        )
    expected = f"one of {', '.join(map(repr, kinds))}"
    if "kind" not in value:
        return (*place, "kind"), "nothing", expected, ""
    return (*place, "kind"), shown(value["kind"]), expected, did_you_mean(value["kind"], kinds)


def _table_at(loc: tuple[int | str, ...]) -> type[BaseModel]:
    """The table that the last part of a place is a key of."""
    table: type[BaseModel] = ScenarioTable
    for part in loc[:-1]:
        if part in TABLES:
            table = TABLES[str(part)]
        elif isinstance(part, str) and part in table.model_fields:
            table = _inner(table.model_fields[part].annotation) or table
    return table


def _inner(annotation: Any) -> type[BaseModel] | None:
    """The one table in a type, where there is one."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = {table for part in typing.get_args(annotation) if (table := _inner(part))}
    return found.pop() if len(found) == 1 else None


def _meaning(loc: tuple[int | str, ...]) -> str:
    fields: Mapping[str, Any] = _table_at(loc).model_fields
    field = fields.get(str(loc[-1]))
    return (field.description if field is not None else None) or "a choice"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
