"""`stillreach doctor`: what is installed, what is missing and how to get it."""

from __future__ import annotations

from stillreach.cli import _options as option

_HIDDEN_EXTRAS = ("all", "test")


def doctor(as_json: option.Json = False) -> None:
    """Show what is installed and what is missing.

    Shows the active instruction path and the command that installs each missing extra.
    """
    import platform
    from importlib import metadata

    from stillreach import _core
    from stillreach.cli._terminal import console, print_json, print_table, table

    versions = {
        extra: {package: _version(package) for package in packages} for extra, packages in _packages_by_extra().items()
    }
    found = {
        "stillreach": metadata.version("stillreach"),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
        "instruction_path": _core.instruction_set(),
        "packages": {package: version for packages in versions.values() for package, version in packages.items()},
        "missing_extras": [extra for extra, packages in versions.items() if extra and None in packages.values()],
    }
    if as_json:
        print_json(found)
        return
    out = console()
    out.print(f"stillreach {found['stillreach']}, Python {found['python']}")
    out.print(f"{found['system']} on {found['machine']}, instruction path {found['instruction_path']}\n")
    made = table("extra", "package", "version")
    for extra, packages in versions.items():
        for package, version in packages.items():
            made.add_row(extra or "(always)", package, version or "missing", style=None if version else "red")
    print_table(made)
    for extra in found["missing_extras"]:
        out.print(f"\nto install missing packages: pip install 'stillreach[{extra}]'", soft_wrap=True)


def _packages_by_extra() -> dict[str, list[str]]:
    """Packages that each extra brings, from the installed metadata; "" has the required packages."""
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
