"""The arguments and options that more than one command has."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from stillreach.cli._complete import complete_law, complete_robot, complete_scenario

Robot = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="A URDF or MJCF file, - for standard input, or a built-in arm.",
        autocompletion=complete_robot,
    ),
]
SCENARIO = typer.Argument(metavar="SCENARIO", help="A scenario file or a ready one.", autocompletion=complete_scenario)
Tip = Annotated[str | None, typer.Option(help="Link (URDF), body or site (MJCF) that carries the tool.")]
Base = Annotated[str | None, typer.Option(help="Link or body that the chain starts from.")]
Fixed = Annotated[
    list[str] | None,
    typer.Option(metavar="JOINT=VALUE", help="Hold a joint of the chain, and leave it out of the arm."),
]
Outside = Annotated[bool, typer.Option("--outside", help="Accept --q outside the position limits.")]
Frame = Annotated[str, typer.Option(help="Axes of these rows: base or tool.")]
RecordedRobot = Annotated[
    str | None,
    typer.Option(
        "--robot", metavar="ROBOT", help="Of the recording: URDF or MJCF file or name.", autocompletion=complete_robot
    ),
]
Law = Annotated[
    str | None,
    typer.Option(
        help="Law instead of the scenario's, e.g. keep-direction or least-error:price=position-first.",
        autocompletion=complete_law,
    ),
]
Fail = Annotated[
    list[str] | None,
    typer.Option(
        metavar="JOINT[@S][:KIND]",
        help="One more fault: j4@2 locks j4 after 2 s, j4@2:derated=0.3 leaves it 30 % of its speed.",
    ),
]
Healthy = Annotated[bool, typer.Option("--healthy", help="Leave out the scenario's own faults.")]
KnownAfter = Annotated[
    str | None,
    typer.Option(
        metavar="TIME", help="The controller learns of every fault this much later, e.g. 40ms; never: not at all."
    ),
]
Threads = Annotated[int | None, typer.Option(min=1, help="By default one a processor.")]
Out = Annotated[Path | None, typer.Option(help="Output folder; by default out/NAME.")]
Json = Annotated[bool, typer.Option("--json", help="Print only JSON.")]


def allowed(text: str) -> Any:
    """An allowed distance and angle."""
    return typer.Option(metavar="LENGTH[,ANGLE]", help=text)


def configured(text: str) -> Any:
    """A configuration of the arm, and what it is for."""
    return typer.Option(
        "--q",
        metavar="VALUES",
        help=f"{text}: values or joint=value pairs separated by commas, in rad and m or with a unit (-90deg, 50mm); "
        "zero; middle (of the limits); or best (default), where the tool moves best.",
    )


def drawn(name: str) -> Any:
    """Whether to draw a picture with this name."""
    return typer.Option("--plot/--no-plot", help=f"Draw {name}; by default if matplotlib is installed.")


@dataclass(frozen=True)
class Recording:
    """The options of a recording: the chain of its robot, and how its file is read."""

    tip: Tip = None
    base: Base = None
    angle: Annotated[
        str | None, typer.Option("--angle", metavar="UNIT", help="rad or deg: of a table that does not say its unit.")
    ] = None
    topic: Annotated[
        str | None,
        typer.Option("--topic", help="Of the joint states, where a bag has several; or of poses of the tool alone."),
    ] = None
    episode: Annotated[int | None, typer.Option("--episode", help="Of a dataset with several.")] = None
    period: Annotated[
        str | None,
        typer.Option("--period", metavar="TIME", help="Between two ticks on a recording, e.g. 4ms; by default 10ms."),
    ] = None

    def given(self) -> dict[str, Any]:
        """Those that the user gave, by name."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def of_recording(command: Callable[..., None]) -> Callable[..., None]:
    """A command with these options in the place of its argument ``options``."""
    hints = get_type_hints(Recording, include_extras=True)
    own, options = inspect.signature(command, eval_str=True).parameters, []
    for name, parameter in own.items():
        options += (
            [inspect.Parameter(name, parameter.kind, default=None, annotation=hint) for name, hint in hints.items()]
            if name == "options"
            else [parameter]
        )

    @wraps(command)
    def called(**values: Any) -> None:
        command(options=Recording(**{name: values.pop(name) for name in hints}), **values)

    called.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in options}
    return called
