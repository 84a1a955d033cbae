"""The part of an XML file that a robot's kinematics are in, with line numbers; files made to do harm are refused.

Expat of the standard library does the parsing. A document type declaration ends it at once: without one there are no
entities, none that expand without end and none that name other files. Size, depth, number of elements and length of
attributes are bounded. Elements deeper than ``robot/joint/*`` are looked at for their names only.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from stillreach.arm.robot_file import RobotFile, shown
from stillreach.errors import RobotFileError

MAX_DEPTH = 100
MAX_ELEMENTS = 50_000
MAX_ATTRIBUTE = 1000
KEPT_DEPTH = 3
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
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
    """One element: its tag, attributes, line and, down to ``robot/joint/*``, its children; it makes its own errors.

    A tag of xacro begins with ``xacro:``, whatever prefix the file uses. ``missing``: it is not in the file.
    """

    file: RobotFile
    tag: str
    attributes: dict[str, str]
    line: int
    within: Element | None = None
    missing: bool = False
    children: list[Element] = field(default_factory=list)

    @property
    def label(self) -> str:
        """Its name in messages: ``<robot>``, ``joint 'elbow'``, ``joint 'elbow' <origin>``."""
        tag = f"<{self.tag[:80]}>"
        if self.within is None:
            return tag
        if self.within.within is not None:
            return f"{self.within.label} {tag}"
        return f"{self.tag} {shown(self.word('name'))}" if self.word("name") else tag

    def error(self, got: str, expected: str, **more: Any) -> RobotFileError:
        """An error of this element."""
        return self.file.error(got, expected, line=self.line, element=self.label, **more)

    def unknown(self, value: str, what: str, choices: Iterable[str]) -> RobotFileError:
        """An error of this element that lists the choices."""
        return self.file.unknown(value, what, choices, line=self.line, element=self.label)

    def child(self, tag: str) -> Element:
        """The first child of that tag, like other readers; or one without attributes that is ``missing``."""
        empty = Element(self.file, tag, {}, self.line, self, missing=True)
        return next((child for child in self.children if child.tag == tag), empty)

    def word(self, name: str, default: str = "") -> str:
        """An attribute without the white space around it."""
        return self.attributes.get(name, default).strip()

    def number(self, name: str, default: float, largest: float = math.inf) -> float:
        """The number in an attribute; the default where it is missing."""
        text = self._text(name)
        return default if text is None else self._number(name, text, largest)

    def numbers(self, name: str, count: int, default: Sequence[float] | None = None, largest: float = math.inf) -> Any:
        """The ``count`` numbers in an attribute; None as default: they are required."""
        text = self._text(name)
        if text is None and default is not None:
            return tuple(default)
        words = [] if text is None else text.split()
        if len(words) != count:
            got = f"no {name}" if text is None else f"{len(words)} numbers in {name}={shown(text)}"
            example = " ".join("0" * (count - 1) + "1")
            raise self.error(got, f"{count} numbers, e.g. {name}='{example}'")
        return tuple(self._number(name, word, largest) for word in words)

    def _text(self, name: str) -> str | None:
        text = self.attributes.get(name)
        if text is not None and "$" in text:
            raise self.error(f"xacro in {name}={shown(text)}", XACRO_ADVICE)
        return text

    def _number(self, name: str, word: str, largest: float) -> float:
        number = float(word) if NUMBER.fullmatch(word.strip()) else math.nan
        if not math.isfinite(number):
            raise self.error(f"{name}={shown(word)}", "a finite number, e.g. '0.5'")
        if abs(number) > largest:
            raise self.error(f"{name}={shown(word)}", f"a number between -{largest:g} and {largest:g}")
        return number


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

    def error(self, got: str, expected: str, element: str | None = None) -> RobotFileError:
        """An error where the parser is."""
        line = self.lines_before + self.parser.CurrentLineNumber
        return self.file.error(got, expected, line=line, element=element)

    def doctype(self, *_: object) -> None:
        expected = "none: entities could expand without end, or read other files"
        raise self.error("a document type declaration (<!DOCTYPE)", expected)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        self.count += 1
        if self.depth > MAX_DEPTH:
            raise self.error(f"elements nested {self.depth} deep", f"at most {MAX_DEPTH}")
        if self.count > MAX_ELEMENTS:
            raise self.error(f"more than {MAX_ELEMENTS} elements", f"at most {MAX_ELEMENTS}")
        for name, value in attributes.items():
            if name.startswith("xmlns:") and value.rstrip("/").endswith("xacro"):
                self.xacro.add(name[6:])
        prefix, _, word = tag.partition(":")
        if word and prefix in self.xacro:
            if word in EXPANDABLE:
                raise self.error(f"xacro (<{tag[:80]}>)", XACRO_ADVICE, f"<{tag[:80]}>")
            tag = XACRO + word
        if self.depth > KEPT_DEPTH:
            return
        for name, value in attributes.items():
            if len(value) > self.max_attribute:
                got = f"{len(value)} characters in {shown(name)}"
                raise self.error(got, f"at most {self.max_attribute}", f"<{tag[:80]}>")
        line = self.lines_before + self.parser.CurrentLineNumber
        element = Element(self.file, tag, attributes, line, self.open[-1] if self.open else None)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _: str) -> None:
        if self.depth <= KEPT_DEPTH:
            self.open.pop()
        self.depth -= 1
