"""Exit codes and error messages."""

from __future__ import annotations

import sys

DONE = 0
NOT_FINISHED = 1
"""The command worked, but the arm did not finish, or a claim of `paper` has an unexpected result."""
USER = 2
"""An error that the user can fix: an argument, a file, a missing extra."""
BUG = 3
"""An error in stillreach."""
CTRL_C = 130
BROKEN_PIPE = 141
"""A closed pipe: 128 plus the number of SIGPIPE, as for programs that this signal ends."""

BUG_TEXT = "stillreach: this is an error in stillreach, not in your input; please report it with the lines above"


def report(error: Exception, *, debug: bool) -> int:
    """Report an error on standard error.

    Args:
        error: the exception.
        debug: always show the traceback.

    Returns:
        The exit code.
    """
    message = explained(error)
    if debug or message is None:
        import traceback

        traceback.print_exception(error)
    from stillreach._text import printable

    print(_wrapped(printable(BUG_TEXT if message is None else f"stillreach: {message}")), file=sys.stderr)
    return BUG if message is None else USER


def _wrapped(text: str) -> str:
    """The text in lines that fit a terminal, indented from the second on; in a pipe a message stays one line."""
    if not sys.stderr.isatty():
        return text
    import shutil
    import textwrap

    width = shutil.get_terminal_size().columns
    lines = []
    for line in text.splitlines():
        indent = " " * (len(line) - len(line.lstrip()) + 2)
        lines += textwrap.wrap(line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines)


def explained(error: Exception) -> str | None:
    """The message of an error; None if the user cannot fix it."""
    from stillreach.errors import StillreachError

    if isinstance(error, StillreachError):
        return "\n  ".join([str(error), *getattr(error, "__notes__", ())])
    if isinstance(error, MemoryError):
        detail = f" ({error})" if str(error) else ""
        return f"not enough memory{detail}; use a longer step or a shorter duration"
    if isinstance(error, OSError):
        name = error.filename2 or error.filename  # of two names the user knows the second
        place = f"{name}: " if name else ""
        return f"{place}{error.strerror or error}"
    return None
