"""The pages of the documentation, and the code in them."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "ARCHITECTURE.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A fenced block: its code, the line it starts on, and the output that a text block right after it shows."""

    code: str
    line: int
    output: str | None


def blocks(text: str, language: str) -> list[Block]:
    """The blocks of one language in a page."""
    return [
        Block(match[2], text.count("\n", 0, match.start(2)) + 1, match[3])
        for match in BLOCK.finditer(text)
        if match[1] == language
    ]


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()
