"""Output of commands: tables that fit 80 columns with or without colour, notes, and JSON for machines."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text


COLUMNS = 80
"""Width of every table."""


def console(*, stderr: bool = False, width: int | None = None, markup: bool = False) -> Console:
    """A console that prints text unchanged: without emoji and highlighting, with given markup and width."""
    from rich.console import Console

    from stillreach._text import printable

    class _Console(Console):
        def on_broken_pipe(self) -> None:
            nobody_reads()

        def render_str(self, text: str, **settings: Any) -> Text:
            return super().render_str(printable(text), **settings)

    return _Console(stderr=stderr, width=width, highlight=False, emoji=False, markup=markup)


def nobody_reads() -> NoReturn:
    """End with the exit code of a closed pipe, e.g. with ``head``."""
    from stillreach.cli._exit import BROKEN_PIPE

    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # unwritten output
    sys.exit(BROKEN_PIPE)


def print_table(made: Table) -> None:
    """A table; a terminal that is too narrow wraps its lines, so numbers are never truncated."""
    out = console()
    (out if out.width >= COLUMNS else console(width=COLUMNS)).print(made)


def table(*heads: str, right: tuple[int, ...] = (), wrap: tuple[int, ...] = ()) -> Table:
    """An empty table with a rule below its head.

    Args:
        heads: titles of the columns.
        right: indices of numeric columns.
        wrap: indices of columns that may wrap; the others keep their width.
    """
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="bold", padding=(0, 1, 0, 0))
    for place, head in enumerate(heads):
        made.add_column(head, justify="right" if place in right else "left", no_wrap=place not in wrap, overflow="fold")
    return made


def facts(rows: list[tuple[str, str]]) -> Table:
    """Names and values in two columns."""
    from rich.table import Table

    made = Table(box=None, pad_edge=False, show_header=False)
    made.add_column(no_wrap=True, style="bold")
    made.add_column(overflow="fold")
    for name, text in rows:
        made.add_row(name, text)
    return made


def note(text: str) -> None:
    """A note on standard error."""
    console(stderr=True).print(text, soft_wrap=True)


def print_json(value: Any) -> None:
    """A value as JSON on standard output; infinite and undefined numbers are null."""
    try:
        print(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False), flush=True)
    except BrokenPipeError:
        nobody_reads()


def tell(facts: dict[str, Any], written: Sequence[Path], as_json: bool, show: Callable[[], None]) -> None:
    """What a command found, as JSON or shown in words, and the files that it wrote."""
    if as_json:
        print_json({**facts, "files": [str(path) for path in written]})
    else:
        show()
        console().print(f"\nwrote {', '.join(map(str, written))}", soft_wrap=True)


def plain(value: Any) -> Any:
    """The value in JSON's own types."""
    if hasattr(value, "tolist"):  # NumPy
        value = value.tolist()
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
