"""`stillreach schema`: the JSON schema of scenario files, for editors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def schema(
    out: Annotated[Path | None, typer.Option(help="Write it to this file instead of standard output.")] = None,
) -> None:
    """Print the JSON schema of scenario files, for editors."""
    from stillreach.cli._terminal import console, print_json
    from stillreach.simulation import scenario_schema

    if out is None:
        print_json(scenario_schema())
        return
    import json

    from stillreach._files import new_file

    with new_file(out) as file:
        file.write((json.dumps(scenario_schema(), indent=2, ensure_ascii=False) + "\n").encode())
    console().print(f"wrote {out}", soft_wrap=True)
