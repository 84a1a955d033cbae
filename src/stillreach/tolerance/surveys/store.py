"""A survey on disk: labelled arrays in Zarr, a row a chunk; a chunk counts once ``done`` says so, which comes last."""

from __future__ import annotations

import json
import os
import platform
import secrets
import shutil
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach import _core
from stillreach._files import file_name
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation.document import settings_text
from stillreach.tolerance.surveys.arrays import ALL, REDUCED, Arrays, Variable, coordinates, lengths, variables
from stillreach.tolerance.surveys.plan import FORMAT, Plan

EXPECTED = "a folder that tolerance.survey() wrote"
SAME_BITS = {"avx512": "avx2"}
"""Instruction sets that compute the same bits as another."""
WORDS = {
    "robot": "another robot",
    "task": "another task",
    "configurations": "other configurations",
    "failures": "other sets of joints",
    "metrics": "other metrics",
    "seed": "another seed",
    "chunk": "another size of chunks",
    "keep": "another keep",
    "starts": "another number of starts",
}


class Build(NamedTuple):
    """What decides the bits of a result.

    Args:
        version: of stillreach.
        instructions: the instruction set, AVX2's for AVX-512's, which computes the same.
        machine: the kind of processor.
    """

    version: str
    instructions: str
    machine: str

    @classmethod
    def here(cls) -> Build:
        """That of this process."""
        own = _core.instruction_set()
        return cls(version("stillreach"), SAME_BITS.get(own, own), platform.machine())

    def __str__(self) -> str:
        return f"stillreach {self.version} with {self.instructions} on {self.machine}"


def zarr_or_error() -> Any:
    """The module zarr.

    Raises:
        MissingExtraError: if it is not installed.
    """
    try:
        import zarr
    except ImportError as error:
        raise MissingExtraError("survey", "a survey") from error
    return zarr


class Store:
    """The folder of a survey.

    Args:
        folder: it exists.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            if not folder.is_dir():
                raise NotADirectoryError
            self.group = zarr_or_error().open_group(str(folder), mode="r+", zarr_format=2)
        except (FileNotFoundError, NotADirectoryError, ValueError, TypeError):
            raise InputError("out", f"{str(folder)!r}, which is something else", EXPECTED) from None
        attrs = dict(self.group.attrs)
        if not {"format", "survey", "build", "robot"} <= attrs.keys():
            raise InputError("out", f"{str(folder)!r}, which is something else", EXPECTED)
        if attrs["format"] != FORMAT:
            raise InputError("out", f"a survey of format {attrs['format']!r}", f"format {FORMAT}, of this version")
        self.document: dict[str, Any] = json.loads(str(attrs["survey"]))
        self.build = Build(*map(str, json.loads(str(attrs["build"]))))
        self.robot = str(attrs["robot"])

    @property
    def done(self) -> npt.NDArray[np.bool_]:
        """(chunks,) which are finished."""
        return np.asarray(self.group["done"][:], dtype=bool)

    def write(self, plan: Plan, index: int, arrays: Arrays) -> None:
        """A chunk; what a killed process wrote of it before is replaced."""
        first = index * plan.chunk
        for name, values in arrays.items():
            place = slice(first, first + plan.size(index)) if name in ALL else index
            self.group[name][place] = values
        self.group["done"][index] = 1

    def check(self, plan: Plan, build: Build) -> None:
        """Raises InputError unless the folder is that of this survey."""
        other = [name for name, value in plan.document.items() if self.document.get(name) != value]
        if other:
            words = ", ".join(WORDS[name] for name in other)
            raise InputError("out", f"the folder {str(self.folder)!r} of a survey with {words}", "another folder")
        if self.build != build:
            got = f"the folder {str(self.folder)!r} of a survey begun by {self.build}"
            raise InputError("out", got, f"the same to go on with it; this is {build}")


def opened(out: str | os.PathLike[str], plan: Plan, build: Build, resume: bool) -> Store:
    """The folder of a survey: a new one, or the one in which it was begun."""
    folder = Path(file_name("out", out))
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        store = Store(folder)
        store.check(plan, build)
        if not resume:
            raise InputError("out", f"the folder {str(folder)!r} of this survey", "a new folder, or resume=True")
        return store
    folder.parent.mkdir(parents=True, exist_ok=True)
    part = folder.parent / f".stillreach-{secrets.token_hex(8)}.part"
    try:
        _create(part, plan, build)
        part.replace(folder)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise
    return Store(folder)


def _create(folder: Path, plan: Plan, build: Build) -> None:
    """All arrays, empty, with labels and attributes."""
    zarr = zarr_or_error()
    group = zarr.open_group(str(folder), mode="w", zarr_format=2)
    group.attrs.update(
        {
            "title": f"survey of {plan.arm.name}",
            "format": FORMAT,
            "source": f"stillreach {build.version}",
            "instruction_set": build.instructions,
            "build": json.dumps(build),
            "robot_sha256": plan.document["robot"],
            "robot": settings_text(plan.arm),
            "survey": json.dumps(plan.document),
        }
    )
    sizes = lengths(plan)
    used = {"chunk"}
    for table, first, each in ((REDUCED, "chunk", 1), (ALL, "configuration", plan.chunk)):
        for name, entry in variables(plan, table).items():
            dims = (first, *entry.dims)
            shape = tuple(sizes[dim] for dim in dims)
            _array(group, name, shape, (each, *shape[1:]), entry.dtype, dims, entry)
            used.update(dims)
    _array(group, "done", (plan.chunks,), (1,), "i1", ("chunk",), Variable("", (), "i1", "1: the chunk is finished"))
    for name, (dim, values, meaning) in coordinates(plan).items():
        if dim in used:
            entry = Variable("", (), values.dtype.str, meaning)
            _array(group, name, values.shape, values.shape, values.dtype.str, (dim,), entry)[...] = values
    zarr.consolidate_metadata(str(folder), zarr_format=2)


def _array(
    group: Any,
    name: str,
    shape: tuple[int, ...],
    chunks: tuple[int, ...],
    dtype: str,
    dims: tuple[str, ...],
    entry: Variable,
) -> Any:
    labels = {"_ARRAY_DIMENSIONS": list(dims), "long_name": entry.meaning, "units": entry.units}
    return group.create_array(name, shape=shape, chunks=chunks, dtype=dtype, fill_value=None, attributes=labels)
