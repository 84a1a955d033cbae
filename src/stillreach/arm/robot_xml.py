"""The part of an XML file that a robot's kinematics are in, with line numbers; files made to do harm are refused.

Expat of the standard library does the parsing. A document type declaration ends it at once: without one there are no
entities, none that expand without end and none that name other files. Size, depth, number of elements and length of
attributes are bounded. Elements deeper than ``robot/joint/*`` are looked at for their names only.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from xml.parsers import expat

from stillreach.arm.robot_file import RobotFile, shown
from stillreach.errors import RobotFileError

MAX_DEPTH = 100
MAX_ELEMENTS = 50_000
MAX_ATTRIBUTE = 1000
KEPT_DEPTH = 3
BEFORE_DECLARATION = re.compile(rb"(?:\xef\xbb\xbf)?(?:[ \t\r\n]|<\?xml[ \t\r\n][^>]*>)+(?=<\?xml[ \t\r\n])")
"""White space or another declaration, which XML forbids there and most readers skip."""
AFTER_THE_END = re.compile(rb"(?<=>)\s*\0[\0\s]*\Z")
"""The zero that ends a text in C."""
COMMENT_OR_CDATA = re.compile(rb"<!--|<!\[CDATA\[")
BLANK = bytes(byte if byte in b"\r\n" else ord(" ") for byte in range(256))
XACRO = "xacro:"
EXPANDABLE = {"include", "macro", "call", "insert_block", "if", "unless", "element", "attribute"}
"""Of xacro's own elements, those that can add links or joints; a call of a macro that the file lacks cannot."""
XACRO_ADVICE = "a plain URDF file: expand xacro first, e.g. `xacro robot.urdf.xacro > robot.urdf`"


@dataclass
class Element:
    """One element: its tag, attributes, line and, down to ``robot/joint/*``, its children.

    A tag of xacro begins with ``xacro:``, whatever prefix the file uses.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)


def parse(file: RobotFile, max_attribute: int = MAX_ATTRIBUTE) -> Element:
    """The root element of a robot file; no attribute that is kept may be longer than ``max_attribute``.

    Raises:
        RobotFileError: not well-formed, xacro, a document type declaration, too deep, too long an attribute.
    """
    data = _without_comments(AFTER_THE_END.sub(b"", file.data))
    before = BEFORE_DECLARATION.match(data)
    start = before.end() if before else 0
    reader = _Reader(file, max_attribute, lines_before=len(re.findall(rb"\r\n|\r|\n", data[:start])))
    try:
        reader.parser.Parse(data[start:], True)
    except expat.ExpatError as error:
        got = f"{expat.ErrorString(error.code)} at column {error.offset + 1}"
        raise file.error(got, "well-formed XML", line=reader.lines_before + error.lineno) from None
    except RobotFileError:
        raise
    except (LookupError, ValueError) as error:  # an encoding that Python or expat cannot do
        raise file.error(f"an encoding that cannot be read ({error})", "UTF-8", line=1) from None
    return reader.root


def _without_comments(data: bytes) -> bytes:
    """Spaces in place of comments: XML forbids ``--`` in them, and most readers do not."""
    parts, at = list[bytes](), 0
    while opening := COMMENT_OR_CDATA.search(data, at):
        is_comment = opening[0] == b"<!--"
        end = data.find(b"-->" if is_comment else b"]]>", opening.end()) + 3
        if end < 3:  # not closed
            break
        parts.append(data[at : opening.start()])
        inside = data[opening.start() : end]
        parts.append(inside.translate(BLANK) if is_comment else inside)
        at = end
    return b"".join([*parts, data[at:]])


class _Reader:
    """Handlers for expat, and the elements that they met."""

    def __init__(self, file: RobotFile, max_attribute: int, lines_before: int) -> None:
        self.file = file
        self.max_attribute = max_attribute
        self.lines_before = lines_before
        self.open: list[Element] = []
        self.depth = self.count = 0
        self.xacro = {"xacro"}  # prefixes of elements that are to be expanded
        self.root: Element
        self.parser = expat.ParserCreate(file.encoding)
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end

    @property
    def line(self) -> int:
        """Where the parser is."""
        return self.lines_before + self.parser.CurrentLineNumber

    def doctype(self, *_: object) -> None:
        raise self.file.error(
            "a document type declaration (<!DOCTYPE)",
            "none: entities could expand without end, or read other files",
            line=self.line,
        )

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.line
        self.depth += 1
        self.count += 1
        if self.depth > MAX_DEPTH:
            raise self.file.error(f"elements nested {self.depth} deep", f"at most {MAX_DEPTH}", line=line)
        if self.count > MAX_ELEMENTS:
            raise self.file.error(f"more than {MAX_ELEMENTS} elements", f"at most {MAX_ELEMENTS}", line=line)
        for name, value in attributes.items():
            if name.startswith("xmlns:") and value.rstrip("/").endswith("xacro"):
                self.xacro.add(name[6:])
        prefix, _, word = tag.partition(":")
        if word and prefix in self.xacro:
            if word in EXPANDABLE:
                raise self.file.error(f"xacro (<{tag[:80]}>)", XACRO_ADVICE, line=line, element=f"<{tag[:80]}>")
            tag = XACRO + word
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
