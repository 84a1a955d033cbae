"""Commands run in this process, as `stillreach` in a shell runs them."""

import contextlib
import io
import os
import sys
from pathlib import Path
from typing import NamedTuple
from unittest import mock

from stillreach.cli import main


class Answer(NamedTuple):
    code: int
    out: str
    err: str


def run_command(*arguments: object, folder: Path | str = ".", columns: int | None = 80) -> Answer:
    """Exit code, output and messages of a command in a folder; `columns` of the terminal, None as the shell says."""
    variables = {"NO_COLOR": "1"} | ({"COLUMNS": str(columns)} if columns else {})
    with (
        contextlib.chdir(folder),
        mock.patch.dict(os.environ, variables),
        mock.patch.object(sys, "argv", ["stillreach", *map(str, arguments)]),
        contextlib.redirect_stdout(io.StringIO()) as out,
        contextlib.redirect_stderr(io.StringIO()) as err,
    ):
        try:
            main()
            code = 0
        except SystemExit as done:
            code = int(done.code or 0)
    return Answer(code, out.getvalue(), err.getvalue())
