"""The command line: one thin file per command, each calling the public API."""

import sys


def main() -> None:
    """Runs the command named by the process's arguments and exits.

    The exit codes are those of ``stillreach.cli._exit``: 0 done, 1 done but the arm or a claim failed, 2 a mistake of
    the user, 3 a mistake of stillreach, 130 Ctrl-C, 141 output that nobody reads any more.
    """
    arguments = sys.argv[1:]
    debug = "--debug" in arguments
    try:
        for stream in (sys.stdout, sys.stderr):  # a terminal without σ gets "?", not a crash
            if hasattr(stream, "reconfigure"):
                stream.reconfigure(errors="replace")
        from stillreach.cli._app import app

        app([argument for argument in arguments if argument != "--debug"], prog_name="stillreach")
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:
        from stillreach.cli._exit import report

        sys.exit(report(error, debug=debug))
