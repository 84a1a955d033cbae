"""A layer imports earlier layers, never later ones, and no module itself by way of others; as ARCHITECTURE.md says."""

import ast
import graphlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "stillreach"

LAYERS = (
    {
        "_core",
        "_cpp",
        "errors",
        "_labels",
        "_door",
        "_files",
        "_text",
        "_units",
        "_rotations",
        "_formats",
        "_messages",
        "_packages",
        "_words",
    },
    {"arm"},
    {"arms"},
    {"_forms", "_kinds", "_lists", "_reading", "_tables"},
    {"bounds", "faults", "null_motions", "physics", "plants", "task", "status", "insight"},
    {"laws"},
    {"batch", "inverse", "inverse_result", "rollouts"},
    {"control"},
    {"bags"},
    {"simulation"},
    {"recordings"},
    {"tolerance"},
    {"page"},
    {"show"},
    {"paper"},
    {"cli", "__main__"},
)
RANK = {name: rank for rank, names in enumerate(LAYERS) for name in names}
PUBLIC_API = RANK["tolerance"]  # `import stillreach` brings in everything up to here
# (layer, function, imported layer)
ALLOWED = {
    ("arm", "inverse", "inverse"),
    *((layer, "plot", "show") for layer in ("arm", "simulation", "tolerance")),
    ("tolerance", "html", "show"),
    *((layer, "page", "page") for layer in ("arm", "simulation")),
}
HEADER_LAYERS = ("simd", "linear", "kinematics", "problem", "bounded", "laws", "control", "batch", "urdf")
LAST_HEADERS = {
    "kernel.hpp",
    "dispatch.hpp",
    "memory.hpp",
    "cuda.hpp",
    "stillreach.hpp",
    "urdf.hpp",
}  # config.hpp and types.hpp come first


def header_rank(path: str) -> int:
    """The layer of a header below `include/stillreach`."""
    folder, _, name = path.rpartition("/")
    if folder:
        return HEADER_LAYERS.index(folder)
    return len(HEADER_LAYERS) if name in LAST_HEADERS else -1


def imported_modules(node: ast.AST, module: tuple[str, ...], is_package: bool) -> Iterator[tuple[str, ...]]:
    """Dotted names below `stillreach` that one statement imports, of modules or in them; () is the package itself."""
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        keep = len(module) - node.level + is_package
        parts = ["stillreach", *module[:keep]] if node.level else []
        base = ".".join([*parts, *filter(None, [node.module])])
        names = [f"{base}.{alias.name}" for alias in node.names]
    else:
        return
    for name in names:
        if name == "stillreach" or name.startswith("stillreach."):
            yield tuple(name.split(".")[1:])


def types_alone(node: ast.AST) -> bool:
    """Whether a statement is for type checkers only."""
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def upward_imports(source: str, module: tuple[str, ...], is_package: bool = False) -> list[str]:
    """The imports of one module, anywhere in it, that its layer may not have."""
    layer = module[0]
    found = []

    def visit(node: ast.AST, function: str) -> None:
        if types_alone(node):
            return
        for name in imported_modules(node, module, is_package):
            rank = RANK.get(name[0], PUBLIC_API) if name else PUBLIC_API
            if rank > RANK[layer] and (layer, function, name[0] if name else "") not in ALLOWED:
                found.append(f"{'.'.join(module)}:{node.lineno} imports {'.'.join(('stillreach', *name))}")
        inner = node.name if isinstance(node, ast.FunctionDef) else function
        for child in ast.iter_child_nodes(node):
            visit(child, inner)

    visit(ast.parse(source), "")
    return found


def run_at_import(node: ast.AST) -> Iterator[ast.AST]:
    """The statements below a node that run when their module is imported."""
    for child in ast.iter_child_nodes(node):
        if not types_alone(child) and not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            yield child
            yield from run_at_import(child)


def circle(sources: dict[tuple[str, ...], tuple[str, bool]]) -> list[str]:
    """Modules that import each other in a circle, by name as source and whether it is a package; [] for none."""
    graph: dict[tuple[str, ...], set[tuple[str, ...]]] = {}
    for module, (source, is_package) in sources.items():
        graph[module] = set()
        for statement in run_at_import(ast.parse(source)):
            for name in imported_modules(statement, module, is_package):
                known = [name[:length] for length in range(len(name), 0, -1) if name[:length] in sources]
                graph[module].update(known[:1])
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return [".".join(name) for name in error.args[1]]
    return []


def modules() -> list[tuple[tuple[str, ...], Path]]:
    """Every module of the package but its root `__init__`, which re-exports the public names of all layers."""
    paths = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")
    return [(path.relative_to(PACKAGE).with_suffix("").parts, path) for path in paths]


def test_every_module_belongs_to_a_layer() -> None:
    assert {module[0] for module, _ in modules()} <= RANK.keys()


def test_no_module_imports_a_later_layer() -> None:
    upward = []
    for module, path in modules():
        is_package = module[-1] == "__init__"
        name = module[:-1] if is_package else module
        upward += upward_imports(path.read_text(encoding="utf-8"), name, is_package)
    assert upward == []


def test_no_module_imports_itself_by_way_of_others() -> None:
    sources = {}
    for module, path in modules():
        is_package = module[-1] == "__init__"
        sources[module[:-1] if is_package else module] = path.read_text(encoding="utf-8"), is_package
    assert circle(sources) == []


@pytest.mark.parametrize(
    ("first", "second", "found"),
    [
        ("from stillreach.arm.b import x", "from stillreach.arm import a", True),
        ("from stillreach.arm import b", "from stillreach.arm.a import y", True),
        ("from . import b", "import stillreach.arm.a", True),
        ("from stillreach.arm.b import x", "from stillreach.arm import y", True),
        ("from stillreach.arm.b import x", "def f():\n    from stillreach.arm import a", False),
        ("from stillreach.arm.b import x", "if TYPE_CHECKING:\n    from stillreach.arm import a", False),
        ("from stillreach.arm.b import x", "import stillreach.arm_other", False),
    ],
)
def test_a_circle_of_imports_is_seen(first: str, second: str, found: bool) -> None:
    sources = {("arm",): ("from stillreach.arm.a import y", True), ("arm", "a"): (first, False)}
    assert bool(circle({**sources, ("arm", "b"): (second, False)})) is found


@pytest.mark.parametrize(
    ("module", "statement"),
    [
        ("arm.joint", "from stillreach.bounds import Bounds"),
        ("arm.joint", "from stillreach import laws"),
        ("arm.joint", "from ..laws import LeastError"),
        ("arm.joint", "import stillreach as sr"),
        ("bounds", "from .control import Controller"),
        ("laws.damping", "def solve():\n    import stillreach.simulation.run"),
        ("simulation.run", "def save():\n    from stillreach.show import outcome"),
    ],
)
def test_an_upward_import_is_seen(module: str, statement: str) -> None:
    assert len(upward_imports(statement, tuple(module.split(".")))) == 1


@pytest.mark.parametrize(
    ("module", "statement"),
    [
        ("laws.damping", "from stillreach.bounds import Bounds"),
        ("laws.damping", "from ._door import vector"),
        ("laws.damping", "from .._door import vector"),
        ("laws.damping", "import numpy as np"),
        ("simulation.run", "class Run:\n    def plot(self):\n        from stillreach.show.plots import plot_run"),
        ("paper.claims", "import stillreach as sr"),
    ],
)
def test_a_downward_import_is_allowed(module: str, statement: str) -> None:
    assert upward_imports(statement, tuple(module.split("."))) == []


def test_no_header_includes_a_later_layer() -> None:
    top = ROOT / "include" / "stillreach"
    upward, seen = [], 0
    for header in sorted(top.rglob("*.hpp")):
        name = header.relative_to(top).as_posix()
        for quoted in re.findall(r'#include "(.*)"', header.read_text(encoding="utf-8")):
            included = quoted.removeprefix("stillreach/")
            assert quoted == f"stillreach/{included}", name
            assert (top / included).is_file(), (name, quoted)
            seen += 1
            if header_rank(included) > header_rank(name):
                upward.append(f"{name} includes {included}")
    assert upward == []
    assert seen > 50
