"""What pydantic finds wrong with the form of a file, in the words of this package."""

from __future__ import annotations

import typing
from collections.abc import Mapping
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from stillreach.errors import Mistake, nearest
from stillreach.simulation.scenario_file.document import Document, Place
from stillreach.simulation.scenario_file.fault_forms import FaultTable
from stillreach.simulation.scenario_file.forms import Table
from stillreach.simulation.scenario_file.law_forms import LawTable, NullMotionTable
from stillreach.simulation.scenario_file.robot_forms import ROBOTS
from stillreach.simulation.scenario_file.schema import CHOICES, ScenarioTable
from stillreach.simulation.scenario_file.words import did_you_mean, listed, shown, written

MOST = 100
"""Mistakes in the form of one file that are put into words; of more, only the number is."""

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
    "too_short": "at least {min_length}",
    "too_long": "at most {max_length} entries",
    "string_too_short": "a text, not empty",
    "string_too_long": "at most {max_length} letters",
    "literal_error": "{expected}",
}

BASES: dict[str, type[Table]] = {"faults": FaultTable, "law": LawTable, "null_motion": NullMotionTable}
"""What is known of a table whose kind is not."""

TABLES: dict[str, type[Table]] = {
    **{f"<{kind}>": table for kinds in CHOICES.values() for kind, table in kinds.items()},
    **{f"<{key} robot>": table for key, table in ROBOTS.items()},
    **{f"<any of {key}>": table for key, table in BASES.items()},
}
TAGS = {
    *TABLES,
    "[key]",
    "<one>",
    "<each>",
    "<by joint>",
    "<word>",
    "<number>",
    "<table>",
    "<mask>",
    "<vector>",
    "<matrix>",
}


class Form(NamedTuple):
    """What the form of a file is like.

    Attributes:
        mistakes: what is wrong, each with its place.
        unchecked: places that nothing is known of, because they are in a table of unknown kind.
    """

    mistakes: list[tuple[Place, Mistake]]
    unchecked: list[Place]


def form_of(document: Document) -> Form:
    """Check the form of a file."""
    errors = _errors(ScenarioTable, document.content, ())
    unchecked: list[Place] = []
    for error in errors.copy():
        if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
            more, unknown = _beside_the_kind(error)
            errors += more
            unchecked += [(*_place(document, error["loc"]), key) for key in unknown]
    found = [_mistake(document, error) for error in errors[:MOST]]
    if len(errors) > MOST:
        found.append(((), Mistake("", f"{len(errors) - MOST} more mistakes", "none")))
    return Form(found, unchecked)


def _errors(table: type[BaseModel], content: Any, prefix: tuple[int | str, ...]) -> list[ErrorDetails]:
    try:
        table.model_validate(content)
    except ValidationError as error:
        return [{**entry, "loc": (*prefix, *entry["loc"])} for entry in error.errors(include_url=False)]
    return []


def _beside_the_kind(error: ErrorDetails) -> tuple[list[ErrorDetails], list[str]]:
    """What else is wrong with a table whose kind is none of those there are, as if it were the one that was meant.

    Returns:
        The errors, and the keys that could not be checked.
    """
    loc, value = error["loc"], error["input"]
    if not isinstance(value, dict):
        return [], []
    key = str(loc[0])
    if key == "robot":
        guesses = [(wrong, right) for wrong in list(value)[:MOST] if (right := nearest(wrong, ROBOTS))]
        if not guesses:
            return [], list(value)
        wrong, right = guesses[0]
        renamed = {right if name == wrong else name: entry for name, entry in value.items()}
        return _errors(ROBOTS[right], renamed, (*loc, f"<{right} robot>")), [wrong]
    kind = nearest(value.get("kind"), CHOICES[key])
    if kind:
        return _errors(CHOICES[key][kind], {**value, "kind": kind}, (*loc, f"<{kind}>")), []
    known = {name: entry for name, entry in value.items() if key in BASES and name in BASES[key].model_fields}
    errors = _errors(BASES[key], known, (*loc, f"<any of {key}>")) if key in BASES else []
    return errors, [name for name in value if name not in known]


def _mistake(document: Document, error: ErrorDetails) -> tuple[Place, Mistake]:
    """One of pydantic's errors in words."""
    loc = error["loc"]
    place = _place(document, loc)
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    got, expected, hint = shown(value), error["msg"], ""
    if kind == "missing":
        got, expected = "nothing", f"this key: {_meaning(loc)}"
    elif kind == "extra_forbidden":
        keys = list(_table_at(loc).model_fields)
        got, expected = f"an unknown key {shown(place[-1])}", f"one of {listed(keys)}"
        hint = did_you_mean(place[-1], keys)
    elif kind in ("union_tag_invalid", "union_tag_not_found"):
        place, got, expected, hint = _no_kind(place, value)
    elif kind == "literal_error":
        choices = [choice.strip(" '") for choice in context["expected"].replace(" or ", ", ").split(",")]
        expected = f"{'one of ' if len(choices) > 1 else ''}{', '.join(map(repr, choices))}"
        hint = did_you_mean(value, choices)
    elif kind in EXPECTED:
        expected = EXPECTED[kind].format_map(context)
        if kind == "too_short":
            expected += " entry" if context["min_length"] == 1 else " entries"
        if kind == "float_type" and isinstance(value, str) and _is_number(value):
            hint = "a number has no quotes"
    return place, Mistake(written(place), got, expected, hint, document.line(place))


def _place(document: Document, loc: tuple[int | str, ...]) -> Place:
    """Where a value stands in the file: pydantic's place without the tags of the forms that were tried."""
    place: Place = ()
    node: Any = document.content
    for part in loc:
        inside = isinstance(node, dict) and part in node
        if part in TAGS and not inside:
            continue
        place = (*place, part)
        is_entry = isinstance(node, list) and isinstance(part, int) and part < len(node)
        node = node[part] if inside or is_entry else None
    return place


def _no_kind(place: Place, value: Any) -> tuple[Place, str, str, str]:
    """A table that is none of the kinds there are: place, got, expected, hint."""
    if not isinstance(value, dict):
        return place, shown(value), "a table", ""
    kinds = CHOICES.get(str(place[0]))
    if kinds is None:  # the robot, which has no kind but a key of its own
        got = f"the keys {listed(value)}" if value else "an empty table"
        near = next(filter(None, (did_you_mean(key, ROBOTS) for key in list(value)[:MOST])), "")
        return place, got, f"one of the keys {', '.join(ROBOTS)}", near
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
    """What a key that is missing holds, in the words of the schema."""
    fields: Mapping[str, Any] = _table_at(loc).model_fields
    field = fields.get(str(loc[-1]))
    words = (field.description if field is not None else None) or "a value"
    return words[:1].lower() + words[1:].rstrip(".") if not words[1:2].isupper() else words.rstrip(".")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
