"""The command line: one thin file per command, each calling the public API."""

import sys


def main() -> None:
    """Runs the command named by the process's arguments and exits.

    The exit code is 0 when all went well, 1 for an error or a claim that fails, 2 for wrong usage and 130 for Ctrl-C.
    """
    from stillreach.cli._app import app

    try:
        app()
    except Exception as error:
        from stillreach.errors import StillreachError

        if not isinstance(error, StillreachError):
            raise
        print(f"stillreach: {error}", file=sys.stderr)
        sys.exit(1)
