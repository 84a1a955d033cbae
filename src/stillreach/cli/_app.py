"""The typer application: what `stillreach --help` lists.

Its import must stay fast: commands import NumPy, the core and plots when they run.
"""

from typing import Annotated

import typer

from stillreach.cli.arms import arms
from stillreach.cli.compare import compare
from stillreach.cli.convert import convert
from stillreach.cli.doctor import doctor
from stillreach.cli.inspect import inspect
from stillreach.cli.paper import paper
from stillreach.cli.reach import reach
from stillreach.cli.rehearse import rehearse
from stillreach.cli.run import run
from stillreach.cli.schema import schema
from stillreach.cli.survey import survey
from stillreach.cli.view import view

app = typer.Typer(
    name="stillreach",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help is twice as fast
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 done, 1 the arm did not finish or a claim fails, 2 invalid input, 130 Ctrl-C.",
)
for command in (run, compare, rehearse, view, convert, inspect, reach, survey, arms, schema, paper, doctor):
    app.command()(command)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"stillreach {version('stillreach')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", help="Also show the traceback of an error (allowed anywhere on the line).")
    ] = False,
) -> None:
    """Keeps a redundant robot arm on its task after joints fail."""
