"""The typer application: what `stillreach --help` lists.

Importing it must stay quick: commands import what they need (NumPy, the core, plots) when they run.
"""

from typing import Annotated

import typer

from stillreach.cli.doctor import doctor
from stillreach.cli.paper import paper

app = typer.Typer(
    name="stillreach",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: half the time to the answer
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(paper)
app.command()(doctor)


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
) -> None:
    """Keeps a redundant robot arm on its task after joints fail."""
