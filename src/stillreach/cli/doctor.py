"""`stillreach doctor`: what is installed, what is missing and how to get it."""

_HIDDEN_EXTRAS = ("all", "test")


def doctor() -> None:
    """Show what is installed and what is missing.

    Names the instruction path that is active and the command that installs each missing extra.
    """
    import platform
    from importlib import metadata

    from rich.console import Console
    from rich.table import Table

    from stillreach import _core

    console = Console()
    console.print(f"stillreach {metadata.version('stillreach')}, Python {platform.python_version()}")
    console.print(f"machine {platform.machine()}, instruction path [bold]{_core.instruction_set()}[/]")
    table = Table("part", "package", "version")
    missing = []
    for extra, packages in _packages_by_extra().items():
        versions = {package: _version(package) for package in packages}
        for package, version in versions.items():
            table.add_row(extra or "always", package, version or "[red]missing[/]")
        if extra and None in versions.values():
            missing.append(extra)
    console.print(table)
    for extra in missing:
        console.print(f"to install what is missing: pip install 'stillreach[{extra}]'", markup=False)


def _packages_by_extra() -> dict[str, list[str]]:
    """Packages that each extra brings, from the installed metadata; "" stands for what is always required."""
    import re
    from importlib import metadata

    packages: dict[str, list[str]] = {"": []}
    for requirement in metadata.requires("stillreach") or []:
        name = re.match(r"[\w.-]+", requirement)
        extra = re.search(r"extra\s*==\s*['\"]([\w-]+)['\"]", requirement)
        key = extra[1] if extra else ""
        if name and key not in _HIDDEN_EXTRAS:
            packages.setdefault(key, []).append(name[0])
    return packages


def _version(package: str) -> str | None:
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
