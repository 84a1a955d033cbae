"""Arguments that say which chain of which robot a command is about."""

from __future__ import annotations

from typing import Annotated

import typer

from stillreach.cli._complete import complete_robot

RobotArgument = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A URDF or MJCF file, - for standard input, or a built-in arm.",
        autocompletion=complete_robot,
    ),
]
TipOption = Annotated[str | None, typer.Option(help="Link (URDF), body or site (MJCF) that carries the tool.")]
BaseOption = Annotated[str | None, typer.Option(help="Link or body that the chain starts from.")]
FixedOption = Annotated[
    list[str] | None,
    typer.Option(metavar="JOINT=VALUE", help="Hold a joint of the chain, and leave it out of the arm."),
]
