"""The numbers in the elements of one URDF joint, each checked."""

from __future__ import annotations

import math
import re

from stillreach.arm.robot_file import RobotFile, shown
from stillreach.arm.robot_xml import XACRO_ADVICE, Element
from stillreach.arm.urdf_tree import UrdfJoint
from stillreach.errors import RobotFileError

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
NO_LIMIT = 1e9
"""A limit of this size or more [SI units] is none: URDF has no word for infinity."""


class JointNumbers:
    """Reads the elements of one joint.

    Args:
        file: for messages.
        joint: whose elements they are.
    """

    def __init__(self, file: RobotFile, joint: UrdfJoint) -> None:
        self.file = file
        self.joint = joint

    def element(self, tag: str) -> Element | None:
        """The first element of that tag, or None; of a second one readers of URDF take no notice."""
        return next((child for child in self.joint.element.children if child.tag == tag), None)

    def one(self, element: Element | None, name: str, default: float, largest: float = math.inf) -> float:
        """The number in an attribute; the default without the element or the attribute."""
        text = None if element is None else element.attributes.get(name)
        return default if element is None or text is None else self._number(element, name, text, largest)

    def limit(self, element: Element | None, name: str, default: float) -> float:
        """A limit; infinite where it is too large to be one."""
        number = self.one(element, name, default)
        return math.copysign(math.inf, number) if abs(number) >= NO_LIMIT else number

    def several(
        self,
        element: Element,
        name: str,
        count: int,
        default: tuple[float, ...] | None = None,
        largest: float = math.inf,
    ) -> tuple[float, ...]:
        """The numbers in an attribute, ``count`` of them; None as default: they must be there."""
        text = element.attributes.get(name)
        if text is None and default is not None:
            return default
        if text is not None and "$" in text:
            raise self.error(element, f"xacro in {name}={shown(text)}", XACRO_ADVICE)
        words = [] if text is None else text.split()
        if len(words) != count:
            got = f"no {name}" if text is None else f"{len(words)} numbers in {name}={shown(text)}"
            example = " ".join("0" * (count - 1) + "1")
            raise self.error(element, got, f"{count} numbers, e.g. {name}='{example}'")
        return tuple(self._number(element, name, word, largest) for word in words)

    def error(self, element: Element | None, got: str, expected: str) -> RobotFileError:
        """An error of this joint, or of one of its elements."""
        tag, line = ("", self.joint.element.line) if element is None else (f" <{element.tag}>", element.line)
        return self.file.error(got, expected, line=line, element=f"{self.joint.label}{tag}")

    def _number(self, element: Element, name: str, word: str, largest: float) -> float:
        if "$" in word:
            raise self.error(element, f"xacro in {name}={shown(word)}", XACRO_ADVICE)
        number = float(word) if NUMBER.fullmatch(word.strip()) else math.nan
        if not math.isfinite(number):
            raise self.error(element, f"{name}={shown(word)}", "a finite number, e.g. '0.5'")
        if abs(number) > largest:
            raise self.error(element, f"{name}={shown(word)}", f"a number between -{largest:g} and {largest:g}")
        return number
