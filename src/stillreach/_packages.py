"""Files that other packages bring: ``package:NAME/PATH``, or a path relative to the scenario file."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

from stillreach._messages import hint, short, shown
from stillreach.errors import InputError

PREFIX = "package:"
WHERE = "relative to this file, or package:NAME/PATH for a file of an installed Python package"
"""Where a file is that a scenario file names, in words."""


def file_at(reference: str, folder: Path) -> Path:
    """Where a file is that a scenario file names.

    Args:
        reference: a path, relative to the folder, or ``package:NAME/PATH`` for a file of an installed package.
        folder: of the scenario file.

    Raises:
        InputError: the package is not installed, or has no such file.
    """
    if reference.startswith(PREFIX):
        return _of_package(reference)
    return folder / reference


def _of_package(reference: str) -> Path:
    name, _, inner = reference.removeprefix(PREFIX).partition("/")
    wanted = tuple(part for part in inner.split("/") if part)
    if not name or not wanted:
        raise InputError("package", shown(reference), f"{PREFIX}NAME/PATH, a file of an installed package")
    try:
        distribution = metadata.distribution(name)
    except (metadata.PackageNotFoundError, ValueError):
        advice = f"a file of the package {short(name)}: pip install --no-deps {short(name)}"
        raise InputError("package", f"{short(name)}, which is not installed", advice) from None
    files = distribution.files or []
    found = next((file for file in files if file.parts[-len(wanted) :] == wanted), None)
    if found is not None:
        return Path(str(distribution.locate_file(found)))
    alike = [file.name for file in files if file.suffix == Path(inner).suffix]
    near = hint(wanted[-1], alike)
    got = f"{shown(inner)}, which {name} {distribution.version} does not have"
    raise InputError("package", got, f"one of its files{f'; {near}' if near else ''}")
