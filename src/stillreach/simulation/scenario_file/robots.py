"""The table of a scenario file's arm, in one of five ways."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stillreach._formats import FORMATS
from stillreach._forms import Integer, Number, Text, Word
from stillreach._kinds import Key, keys_for
from stillreach._lists import MOST_JOINTS, List, Named
from stillreach._messages import listed, nearest
from stillreach._packages import WHERE, file_at
from stillreach._reading import WRONG, Place, Reading
from stillreach._tables import COMPARED, Choice, Table, renamed
from stillreach.arm import Arm, DHRow
from stillreach.arm.dh import CONVENTIONS
from stillreach.arm.joint import KINDS
from stillreach.arms import BUILDERS, SIZED, by_name
from stillreach.errors import InputError, MissingExtraError, RobotFileError

LENGTH, ANGLE, NAME = Number("length"), Number("angle"), Text()
LENGTHS = List(Number("length", least=0.0))
NAMES = {"anyOf": [{"enum": sorted(BUILDERS)}, {"pattern": f"^({'|'.join(SIZED)})[0-9]{{1,4}}$"}]}
"""Of built-in arms, for editors."""
FILES: dict[str, Callable[..., Arm]] = {name: getattr(Arm, f"from_{name}") for name in FORMATS}


class Robot(Choice):
    """The arm, by the one key that each table alone has; what is read after it has its joints."""

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """An Arm."""
        way = next((name for name in self.tables if name in value), None)
        arm = self.tables[way].read(value, place, reading) if way else self._unknown(value, place, reading)
        reading.arm = arm if isinstance(arm, Arm) else None
        return arm

    def _unknown(self, value: dict[str, Any], place: Place, reading: Reading) -> Any:
        """What else is wrong with it, as if it were the one that was meant."""
        meant = [(name, near) for name in list(value)[:COMPARED] if (near := nearest(name, self.tables))][:1]
        got = f"the keys {listed(value)}" if value else "an empty table"
        hint = "".join(reading.hint(wrong, self.tables) for wrong, _ in meant)
        reading.wrong(place, got, f"one of the keys {', '.join(self.tables)}", hint)
        for wrong, near in meant:
            self.tables[near].values(renamed(value, wrong, near), place, reading)
        return WRONG


def _from_file(values: dict[str, Any], reading: Reading) -> Arm:
    kind = next(kind for kind in FILES if kind in values)
    fixed = values.pop("fixed", {})
    try:
        path = file_at(values.pop(kind), reading.folder)
    except InputError as error:
        raise InputError(kind, error.got, error.expected) from None
    try:
        if fixed and not reading.length == reading.angle == 1.0:  # slides and hinges have different units
            reading.arm = FILES[kind](path, **values)
            factors = dict(zip(reading.arm.joint_names, reading.joint_factors(), strict=True))
            fixed = {name: value * factors.get(name, 1.0) for name, value in fixed.items()}
        return FILES[kind](path, fixed=fixed or None, **values)
    except RobotFileError as error:
        argument = error.argument if error.argument in ("tip", "base", "fixed") else kind
        line = f"line {error.line}" if error.line else ""
        place = ", ".join(part for part in (line, error.element) if part)
        raise InputError(argument, f"{place}: {error.got}" if place else error.got, error.expected) from None
    except MissingExtraError as error:
        raise InputError(kind, f"a robot file that {error.extra} reads, which is not installed", str(error)) from None


def _file_table(kind: str) -> Table:
    file = FORMATS[kind]
    own = keys_for(
        FILES[kind],
        **{kind: (Text(), f"The file, {WHERE}")},
        tip=(NAME, f"The {file.tip} that carries the tool"),
        base=(NAME, "What the arm stands on, likewise; the root if absent"),
        fixed=(Named(Number("joint")), "Joints that are held at a value and are no part of the arm"),
    )
    return Table(f"{file.word}Robot", f"A robot from a file in {file.word}.", own, _from_file)


ROW = Table(
    "DHRow",
    "One row of a Denavit-Hartenberg table.",
    keys_for(
        DHRow,
        a=(LENGTH, "Link length, along x"),
        alpha=(ANGLE, "Link twist, about x"),
        d=(LENGTH, "Link offset, along z"),
        theta=(ANGLE, "Joint angle, about z"),
        kind=(Word(*KINDS), "What the joint is"),
        name=(NAME, "The joint's name; j1, j2, ... if absent"),
    ),
    lambda values, reading: DHRow(**values),
)

ROBOT = Robot(
    {
        "arm": Table(
            "BuiltInRobot",
            "An arm that comes with stillreach.",
            {
                "arm": Key(Text(names=NAMES), "Its name, e.g. panda or planar3"),
                "n": Key(
                    Integer(1, MOST_JOINTS),
                    "Number of joints of planar and snake, where it is not part of the name",
                    None,
                ),
                "tip": Key(NAME, "Link that carries the tool (robots by name); the flange if absent", None),
                "lengths": Key(LENGTHS, "Lengths of the segments (nasa_modular)", None),
            },
            lambda values, reading: by_name(values.pop("arm"), **values),
        ),
        "modules": Table(
            "ModuleRobot",
            "An arm of roll and pitch modules, straight up along z at zero.",
            {
                "modules": Key(
                    Text(most=MOST_JOINTS), "R (roll, about the link) and P (pitch, across it), from base to tool"
                ),
                "lengths": Key(
                    LENGTHS, "Base to first pitch, pitch to pitch, last pitch to tool: one more than pitches"
                ),
            },
            lambda values, reading: Arm.from_modules(values["modules"], values["lengths"]),
        ),
        "dh": Table(
            "DHRobot",
            "An arm from Denavit-Hartenberg rows.",
            keys_for(
                Arm.from_dh,
                dh=(List(ROW), "One row for each joint, from the base on"),
                convention=(Word(*CONVENTIONS), "Of the rows; modified is Craig's"),
            ),
            lambda values, reading: Arm.from_dh(values.pop("dh"), **values),
        ),
        **{kind: _file_table(kind) for kind in FORMATS},
    }
)
