"""The forms of settings: how a value is read from a file or a command line, and how an editor's schema describes it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any

from stillreach import _door
from stillreach._messages import one_of, shown
from stillreach._reading import WRONG, Place, Reading
from stillreach._units import ANGLES, LENGTHS, quantity
from stillreach.errors import InputError

LARGEST = 1e9
INF = math.inf
LEAST_TIME = 1e-6
UNITS = {
    "joint": "angle, or length for slides",
    "joint/s": "angle/s, or length/s for slides",
    "joint/s²": "angle/s², or length/s² for slides",
    "arm": "angle; length for an arm of slides",
    "arm/s": "angle/s; length/s for an arm of slides",
}
"""Units that depend on the joint, in words."""

Schema = dict[str, Any]


class Form(ABC):
    """What a value may be; in words, ``expected``, the ``unit`` of its numbers and the ``words`` among its values."""

    expected: str
    unit = ""
    words: tuple[str, ...] = ()
    types: tuple[type, ...] = ()

    def fits(self, value: Any) -> bool:
        """Whether a value is of this form's type."""
        return isinstance(value, self.types) and (bool in self.types or not isinstance(value, bool))

    def read(self, value: Any, place: Place, reading: Reading) -> Any:
        """The value in SI units; WRONG after recording what is wrong with it."""
        if self.fits(value):
            return self.taken(value, place, reading)
        hint = (
            "a number has no quotes" if float in self.types and _is_number(value) else reading.hint(value, self.words)
        )
        return reading.wrong(place, shown(value), self.expected, hint)

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """``read`` of a value of the right type."""
        return value

    def spoken(self, text: str, argument: str, reading: Reading) -> Any:
        """What a text of a command line is in a file; InputError or the text itself where it is something else."""
        return text

    def checked(self, name: str, value: Any) -> Any:
        """A value that Python code gave, in SI units; InputError where it is something else."""
        raise TypeError(f"the constructor checks {name}: {type(self).__name__} is a form of files")

    @abstractmethod
    def schema(self, tables: Schema) -> Schema:
        """Its JSON schema; tables that it refers to are put in ``tables`` by name."""


class Number(Form):
    """A number in a range.

    Args:
        unit: ``"length"``, ``"angle"``, ``"joint"``, ``"arm"``, perhaps by time: ``"joint/s"``; others are kept.
        least, most, above, below: the range; an infinite ``most`` takes infinite numbers.
    """

    types = (int, float)

    def __init__(
        self, unit: str = "", *, least: float = -LARGEST, most: float = LARGEST, above: float = -INF, below: float = INF
    ) -> None:
        self._unit, self._infinite = unit, most == INF
        self.unit = UNITS.get(unit, unit)
        checks = [(above, float.__gt__, "above"), (least, float.__ge__, "of at least")]
        checks += [(most, float.__le__, "of at most"), (below, float.__lt__, "below")]
        self._checks = [(bound, holds, f"a number {words} {bound:g}") for bound, holds, words in checks]
        if least > -LARGEST and most < LARGEST:
            self.expected = f"a number from {least:g} to {most:g}"
            self._checks = [(bound, holds, self.expected) for bound, holds, _ in self._checks]
        elif above > -INF or least == 0.0:
            self.expected = self._checks[above == -INF][2]
        else:
            self.expected = "a number"
        keys = {"exclusiveMinimum": above} if above > -INF else {"minimum": least}
        keys |= {"exclusiveMaximum": below} if below < INF else {"maximum": most}
        self._range = {name: bound for name, bound in keys.items() if math.isfinite(bound)}

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """In SI units."""
        try:
            number = float(value)
        except OverflowError:
            number = math.nan
        if math.isnan(number) or (math.isinf(number) and not self._infinite):
            return reading.wrong(place, shown(value), "a finite number")
        for bound, holds, words in self._checks:
            if not holds(number, bound) and math.isfinite(bound):
                return reading.wrong(place, shown(value), words)
        return number * reading.factor(self._unit)

    def checked(self, name: str, value: Any) -> float:
        """In its range; what only guards files against nonsense is legal."""
        number = _door.scalar(name, value, allow_inf=self._infinite)
        for bound, holds, words in self._checks:
            if abs(bound) < LARGEST and not holds(number, bound):
                raise InputError(name, f"{number:g}", words)
        return number

    def spoken(self, text: str, argument: str, reading: Reading) -> Any:
        """A number, bare or with a unit."""
        kind, _, per = self._unit.partition("/")
        slides = reading.arm is not None and reading.joint is not None and bool(reading.arm.kinds[reading.joint])
        units = {"length": LENGTHS, "angle": ANGLES, "joint": LENGTHS if slides else ANGLES}.get(kind)
        if units is None:
            return float(text) if _is_number(text) else text
        return quantity(argument, text.removesuffix(f"/{per}") if per else text, units)

    def schema(self, tables: Schema) -> Schema:
        """With its range."""
        return {"type": "number", **self._range}


TIME = Number("s", least=LEAST_TIME)
"""A duration."""


class Integer(Form):
    """An integer in a range."""

    types = (int,)

    def __init__(self, least: int, most: int) -> None:
        self.least, self.most = least, most
        self.expected = f"an integer from {least} to {most}"

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As it is."""
        return value if self.least <= value <= self.most else reading.wrong(place, shown(value), self.expected)

    def checked(self, name: str, value: Any) -> int:
        """At least the smallest one; the largest only guards files."""
        return _door.count(name, value, minimum=self.least)

    def schema(self, tables: Schema) -> Schema:
        """With its range."""
        return {"type": "integer", "minimum": self.least, "maximum": self.most}


class Sign(Number):
    """1 or -1."""

    def __init__(self) -> None:
        super().__init__(least=-1.0, most=1.0)
        self.expected = "1 or -1"

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As it is."""
        return float(value) if value in (1, -1) else reading.wrong(place, shown(value), self.expected)

    def checked(self, name: str, value: Any) -> float:
        """As it is."""
        number = super().checked(name, value)
        if number not in (1.0, -1.0):
            raise InputError(name, f"{number:g}", self.expected)
        return number

    def schema(self, tables: Schema) -> Schema:
        """The two."""
        return {"enum": [1, -1]}


class Flag(Form):
    """True or false."""

    types = (bool,)
    expected = "true or false"

    def schema(self, tables: Schema) -> Schema:
        """A boolean."""
        return {"type": "boolean"}


class Text(Form):
    """A text of some letters; an editor knows its ``names`` as a schema, which whatever takes the text checks."""

    types = (str,)
    expected = "a text"

    def __init__(self, least: int = 1, most: int = 1000, names: Schema | None = None) -> None:
        self.least, self.most, self.names = least, most, names or {}

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As it is."""
        if self.least <= len(value) <= self.most:
            return value
        return reading.wrong(place, shown(value), f"at most {self.most} letters" if value else "a text, not empty")

    def schema(self, tables: Schema) -> Schema:
        """With its lengths and names."""
        return {"type": "string", "minLength": self.least, "maxLength": self.most, **self.names}


class Word(Form):
    """One of some words; ``none`` is the one that stands for None in Python."""

    def __init__(self, *words: str, none: str | None = None) -> None:
        self.words, self.none = words, none
        self.expected = one_of(words)

    def fits(self, value: Any) -> bool:
        """Whether it is one of them."""
        return isinstance(value, str) and value in self.words

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As it is, or None."""
        return None if value == self.none else value

    def schema(self, tables: Schema) -> Schema:
        """The choices."""
        return {"type": "string", "enum": list(self.words)} if len(self.words) > 1 else {"const": self.words[0]}


class Either(Form):
    """One of several forms, which differ in type."""

    def __init__(self, *forms: Form) -> None:
        self.forms = forms
        *others, last = [form.expected for form in forms]
        self.expected = f"{', '.join(others)} or {last}"
        self.unit = next((form.unit for form in forms if form.unit), "")
        self.words = tuple(word for form in forms for word in form.words)

    def fits(self, value: Any) -> bool:
        """Whether it is of one of the types."""
        return any(form.fits(value) for form in self.forms)

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As the first form whose type it is."""
        return next(form for form in self.forms if form.fits(value)).taken(value, place, reading)

    def spoken(self, text: str, argument: str, reading: Reading) -> Any:
        """As the first form that takes the text."""
        values = [(form, form.spoken(text, argument, reading)) for form in self.forms]
        return next((value for form, value in values if form.fits(value)), text)

    def schema(self, tables: Schema) -> Schema:
        """Any of them."""
        return {"anyOf": [form.schema(tables) for form in self.forms]}


class JointName(Text):
    """The name of a joint; what is read after it in the same table is this joint's."""

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """A name that the arm has."""
        name = super().taken(value, place, reading)
        if name is WRONG or reading.arm is None:
            return name
        reading.joint = reading.joint_index(place, name)
        return WRONG if reading.joint is None else name


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, str) and math.isfinite(float(value))
    except ValueError:
        return False
