"""The part of an XML file that a robot's kinematics are in, with line numbers; files made to do harm are refused.

Expat of the standard library does the parsing. A document type declaration ends it at once: without one there are no
entities, none that expand without end and none that name other files. Size, depth, number of elements and length of
attributes are bounded. Elements deeper than ``robot/joint/*`` are looked at for their names only.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from stillreach.arm.robot_file import RobotFile, shown
from stillreach.errors import RobotFileError

MAX_DEPTH = 100
MAX_ELEMENTS = 50_000
MAX_ATTRIBUTE = 1000
KEPT_DEPTH = 3
XACRO_ADVICE = "a plain URDF file: expand xacro first, e.g. `xacro robot.urdf.xacro > robot.urdf`"


@dataclass
class Element:
    """One element: its tag, attributes, line and, down to ``robot/joint/*``, its children."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)


def parse(file: RobotFile, max_attribute: int = MAX_ATTRIBUTE) -> Element:
    """The root element of a robot file; no attribute that is kept may be longer than ``max_attribute``.

    Raises:
        RobotFileError: not well-formed, xacro, a document type declaration, too deep, too long an attribute.
    """
    reader = _Reader(file, max_attribute)
    parser = reader.parser
    try:
        parser.Parse(file.data, True)
    except expat.ExpatError as error:
        got = f"{expat.ErrorString(error.code)} at column {error.offset + 1}"
        raise file.error(got, "well-formed XML", line=error.lineno) from None
    except RobotFileError:
        raise
    except (LookupError, ValueError) as error:  # an encoding that Python or expat cannot do
        raise file.error(f"an encoding that cannot be read ({error})", "UTF-8", line=1) from None
    return reader.root


class _Reader:
    """Handlers for expat, and the elements that they met."""

    def __init__(self, file: RobotFile, max_attribute: int) -> None:
        self.file = file
        self.max_attribute = max_attribute
        self.open: list[Element] = []
        self.depth = self.count = 0
        self.xacro = {"xacro"}  # prefixes of elements that are to be expanded
        self.root: Element
        self.parser = expat.ParserCreate(file.encoding)
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end

    def doctype(self, *_: object) -> None:
        raise self.file.error(
            "a document type declaration (<!DOCTYPE)",
            "none: entities could expand without end, or read other files",
            line=self.parser.CurrentLineNumber,
        )

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        self.depth += 1
        self.count += 1
        if self.depth > MAX_DEPTH:
            raise self.file.error(f"elements nested {self.depth} deep", f"at most {MAX_DEPTH}", line=line)
        if self.count > MAX_ELEMENTS:
            raise self.file.error(f"more than {MAX_ELEMENTS} elements", f"at most {MAX_ELEMENTS}", line=line)
        for name, value in attributes.items():
            if name.startswith("xmlns:") and value.rstrip("/").endswith("xacro"):
                self.xacro.add(name[6:])
        if ":" in tag and tag.partition(":")[0] in self.xacro:
            raise self.file.error(f"xacro (<{tag[:80]}>)", XACRO_ADVICE, line=line, element=f"<{tag[:80]}>")
        if self.depth > KEPT_DEPTH:
            return
        self._check_lengths(tag, attributes, line)
        element = Element(tag, attributes, line)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _: str) -> None:
        if self.depth <= KEPT_DEPTH:
            self.open.pop()
        self.depth -= 1

    def _check_lengths(self, tag: str, attributes: dict[str, str], line: int) -> None:
        for name, value in attributes.items():
            if len(value) > self.max_attribute:
                raise self.file.error(
                    f"{len(value)} characters in {shown(name)}",
                    f"at most {self.max_attribute}",
                    line=line,
                    element=f"<{tag[:80]}>",
                )
