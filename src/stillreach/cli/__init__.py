"""The command line: one thin file per command, each calling the public API."""

import os
import sys
from pathlib import Path


def main() -> None:
    """Runs the command named by the process's arguments and exits.

    The exit codes are those of ``stillreach.cli._exit``: 0 done, 1 done but the arm or a claim failed, 2 an error of
    the user, 3 an error of stillreach, 130 Ctrl-C, 141 a closed pipe.
    """
    arguments = sys.argv[1:]
    debug = "--debug" in arguments
    try:
        for name in ("stdout", "stderr"):  # None in a service or in a window without a console
            if getattr(sys, name) is None:
                setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - open to the end
        for stream in (sys.stdout, sys.stderr):  # a terminal without σ shows "?"
            if hasattr(stream, "reconfigure"):
                stream.reconfigure(errors="replace")
        from stillreach.cli._app import app

        app([argument for argument in arguments if argument != "--debug"], prog_name="stillreach")
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        from stillreach.cli._exit import report

        sys.exit(report(error, debug=debug))
