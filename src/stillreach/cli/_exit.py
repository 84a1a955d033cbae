"""Exit codes, and what a shell sees of an error."""

from __future__ import annotations

import sys

DONE = 0
NOT_FINISHED = 1
"""The command did its work, and the answer is no: the arm did not finish, or `paper` found other claims to hold."""
USER = 2
"""Something the user can put right: an argument, a file, a missing extra."""
BUG = 3
"""A mistake of stillreach."""
CTRL_C = 130
BROKEN_PIPE = 141
"""Nobody reads the output any more: 128 and the number of SIGPIPE, as of programs that this signal ends."""

BUG_TEXT = (
    "stillreach: this is a mistake in stillreach, not in what you asked for; please report it with the lines above"
)


def report(error: Exception, *, debug: bool) -> int:
    """Say on standard error what went wrong.

    Args:
        error: what was raised.
        debug: show the traceback also where the message says enough.

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
    """What a user needs to know of an error; None where the error is nothing that a user could put right."""
    from stillreach.errors import StillreachError

    if isinstance(error, StillreachError):
        return "\n  ".join([str(error), *getattr(error, "__notes__", ())])
    if isinstance(error, MemoryError):
        detail = f" ({error})" if str(error) else ""
        return f"this needs more memory than there is{detail}; a longer step or a shorter duration needs less"
    if isinstance(error, OSError):
        name = error.filename2 or error.filename  # of two the second is the one that the user knows
        place = f"{name}: " if name else ""
        return f"{place}{error.strerror or error}"
    return None
