"""stillreach keeps a redundant arm on its task after joints fail.

Given where the joints are, what the tool should do now, what is broken and what the drives allow, it returns the best
joint rates, every control tick, and it always answers.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stillreach import arms as arms
    from stillreach import errors as errors
    from stillreach import insight as insight
    from stillreach import null_motions as null_motions
    from stillreach import plants as plants
    from stillreach import tolerance as tolerance
    from stillreach._core import Solution as Solution
    from stillreach._cpp import *
    from stillreach.arm import *
    from stillreach.batch import *
    from stillreach.bounds import *
    from stillreach.control import *
    from stillreach.errors import InputError as InputError
    from stillreach.errors import StillreachError as StillreachError
    from stillreach.faults import *
    from stillreach.inverse_result import *
    from stillreach.laws import *
    from stillreach.recordings import *
    from stillreach.rollouts import *
    from stillreach.simulation import *
    from stillreach.status import *
    from stillreach.task import *

# Names are imported on first use: `stillreach --version` needs none of them, nor NumPy.
_MODULES = ("arms", "errors", "insight", "null_motions", "plants", "tolerance")
_SINGLE = {"InputError": "errors", "StillreachError": "errors", "Solution": "_core"}
_WHOLE = (
    "_cpp",
    "status",
    "arm",
    "bounds",
    "faults",
    "task",
    "laws",
    "batch",
    "rollouts",
    "inverse_result",
    "control",
    "simulation",
    "recordings",
)
"""Modules whose ``__all__`` is public here, those that need least first."""


def _module(name: str) -> Any:
    return importlib.import_module(f"stillreach.{name}")


def _public() -> list[str]:
    """All public names."""
    return sorted([*_MODULES, *_SINGLE, *(name for home in _WHOLE for name in _module(home).__all__)])


def _found(name: str) -> Any:
    if name in _MODULES:
        return _module(name)
    if name in _SINGLE:
        return getattr(_module(_SINGLE[name]), name)
    if name == "__version__":
        return importlib.import_module("importlib.metadata").version("stillreach")
    if name == "__all__":
        return _public()
    if not name.startswith("_"):
        for home in _WHOLE:
            if name in _module(home).__all__:
                return getattr(_module(home), name)
    raise AttributeError(f"module 'stillreach' has no attribute {name!r}")


def __getattr__(name: str) -> Any:
    value = globals()[name] = _found(name)
    return value


def __dir__() -> list[str]:
    return sorted({*(name for name in globals() if name.startswith("__")), *_public(), "__all__", "__version__"})
