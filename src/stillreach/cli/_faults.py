"""Changes of a scenario by the command line: law and faults."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from stillreach._text import printable
from stillreach._units import quantity
from stillreach.cli._joints import joint_index
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm import Arm
    from stillreach.faults import Fault, FaultKind
    from stillreach.simulation import Scenario


def changed(
    given: str | Scenario, *, law: str | None = None, fail: list[str], healthy: bool, known_after: str | None = None
) -> Scenario:
    """A scenario from a file or by name, with the changes of the options.

    Args:
        given: a scenario, or its file or the name of a ready one.
        law: text of another law; None keeps the scenario's.
        fail: texts of more faults.
        healthy: leave out the scenario's own faults.
        known_after: text of the time after which the controller knows of each fault; None keeps the scenario's.

    Raises:
        InputError: if an option, the file or the name is invalid.
    """
    from stillreach.cli._laws import parse_law
    from stillreach.simulation import Scenario

    scenario = Scenario.load(given) if isinstance(given, str) else given
    faults = () if healthy else tuple(scenario.faults)
    for text in fail:
        fault = parse_fault(scenario.arm, text)
        if scenario.duration is not None and fault.at > scenario.duration:
            raise InputError("--fail", f"{text!r}, after the end at {scenario.duration:g} s", "a time within the task")
        faults += (fault,)
    if known_after is not None:
        faults = tuple(replace(fault, known_after=delay(known_after)) for fault in faults)
    chosen = scenario.law if law is None else parse_law(law, like=scenario.law)
    description = (
        "" if law or fail or healthy or known_after else scenario.description
    )  # it describes the original scenario
    title = scenario.name or (printable(Path(given).stem) if isinstance(given, str) else "")
    return replace(scenario, faults=faults, law=chosen, name=title, description=description)


def delay(text: str) -> float:
    """[s] of ``40ms``, ``0.04`` or ``never``."""
    if text == "never":
        return float("inf")
    seconds = quantity("--known-after", text, {"s": 1.0, "ms": 1e-3})
    if seconds < 0.0:
        raise InputError("--known-after", repr(text), "a time of 0 s or later, such as 40ms, or never")
    return seconds


def parse_fault(arm: Arm, text: str) -> Fault:
    """A fault from ``j4``, ``j4@2.5`` or ``j4@2.5:derated=0.3``.

    Raises:
        InputError: if the text is invalid, or the arm has no such joint.
    """
    from stillreach.faults import Fault

    place, colon, kind = text.partition(":")
    joint, at, onset = place.partition("@")
    if not joint or (at and not onset) or (colon and not kind):
        raise InputError("--fail", repr(text), _expected())
    index = joint_index(arm, "--fail", joint)
    seconds = quantity("--fail", onset, {"s": 1.0}) if at else 0.0
    if seconds < 0.0:
        raise InputError("--fail", repr(text), "a time of 0 s or later")
    return Fault(arm.joint_names[index], at=seconds, kind=fault_kind_of(arm, index, kind or "locked"))


def fault_kind_of(arm: Arm, index: int, text: str, *, option: str = "--fail") -> FaultKind:
    """A kind by its word, with one number for each setting.

    Raises:
        InputError: if the text is invalid.
    """
    from stillreach._kinds import by_word
    from stillreach._reading import Reading
    from stillreach.faults import FAULTS

    name, equals, values = text.partition("=")
    kind = by_word(FAULTS).get(name)
    keys = kind.keys() if kind else {}
    parts = values.split(",") if equals else []
    if kind is None or len(parts) != len(keys):
        raise InputError(option, repr(text), _expected())
    reading = Reading()
    reading.arm, reading.joint = arm, index
    given = {}
    for part, (key, own) in zip(parts, keys.items(), strict=True):
        given[key] = own.form.read(own.form.spoken(part, f"{option} {name}", reading), (key,), reading)
    reading.raise_first(f"{option} {name} ")
    try:
        return kind.read(given, reading)
    except InputError as error:
        raise InputError(f"{option} {name} {error.argument}", error.got, error.expected) from None


def _expected() -> str:
    from stillreach.faults import FAULTS

    texts = ["=".join([kind.word, *filter(None, [",".join(kind.keys()).upper()])]) for kind in FAULTS]
    kinds = f"{', '.join(texts[:-1])} or {texts[-1]}"
    return f"JOINT, JOINT@SECONDS or JOINT@SECONDS:KIND with a kind of {kinds}"
