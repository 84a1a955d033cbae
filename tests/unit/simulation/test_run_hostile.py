"""Files that are no run, and places where none can be written."""

import json
import os
import random
import shutil
import subprocess
import sys
import warnings
from dataclasses import replace

import h5netcdf
import h5py
import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation.record import FIELDS
from stillreach.simulation.run import Run
from tests.refusals import refused
from tests.unit.simulation.scenarios import small_run

RUN = small_run()
SHAPE = RUN.q.shape


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    path = tmp_path_factory.mktemp("good") / "good.nc"
    RUN.save(path)
    return path


@pytest.fixture
def spoiled(good, tmp_path):
    """Copies a good file and lets a function edit it."""

    def copy(edit):
        path = tmp_path / "bad.nc"
        shutil.copy(good, path)
        with h5py.File(path, "r+") as file:
            edit(file)
        return path

    return copy


def other(name, **settings):
    """An edit that puts another array in the place of one of a run's."""

    def edit(file):
        del file[name]
        file.create_dataset(name, **settings)

    return edit


def scenario(change):
    """An edit that changes the scenario: its data, or the whole text."""

    def edit(file):
        changed = change(json.loads(file["scenario"][...].tobytes()))
        text = changed if isinstance(changed, bytes) else json.dumps(changed).encode()
        other("scenario", data=np.frombuffer(text, "S1"))(file)

    return edit


def linked(file):
    del file["q"]
    file["q"] = h5py.SoftLink("/rates")


def linked_to_itself(file):
    del file["q"]
    file["q"] = h5py.SoftLink("/q")


def linked_elsewhere(file):
    del file["q"]
    file["q"] = h5py.ExternalLink("other.nc", "/q")


def virtual(file):
    layout = h5py.VirtualLayout(SHAPE, float)
    layout[...] = h5py.VirtualSource("other.nc", "q", SHAPE)
    del file["q"]
    file.create_virtual_dataset("q", layout)


def group(file):
    del file["q"]
    file.create_group("q")


EDITS = {
    "texts": other("q", data=np.full(SHAPE, b"a")),
    "complex": other("q", data=np.full(SHAPE, 1 + 2j)),
    "integers": other("q", data=np.ones(SHAPE, int)),
    "structures": other("q", data=np.zeros(SHAPE, [("a", float)])),
    "another shape": other("q", data=np.zeros((3, 3))),
    "no axes": other("q", data=1.0),
    "no numbers": other("q", data=h5py.Empty("f8")),
    "room without data": other("q", shape=SHAPE, dtype=float, chunks=True),
    "time of two axes": other("time", data=np.zeros((2, 2))),
    "numbers as names": other("joint", data=np.zeros(SHAPE[1])),
    "names that are not UTF-8": other("joint", data=np.array([b"\xff"] * SHAPE[1], "S1")),
    "a link": linked,
    "a link to itself": linked_to_itself,
    "a link to another file": linked_elsewhere,
    "an array of other files' arrays": virtual,
    "a group": group,
    "a health of 77": lambda file: file["health"].__setitem__(..., 77),
    "a health of -1": lambda file: file["health"].__setitem__(..., -1),
    "an unknown status": lambda file: file["status"].__setitem__(..., 1 << 20),
    "an unknown unit": lambda file: file["joint_unit"].__setitem__(..., np.array(["parsec"] * SHAPE[1], object)),
    "names of other joints": lambda file: file["joint"].__setitem__(0, "another"),
    "a list for a number": lambda file: file.attrs.__setitem__("interrupted", np.zeros(1000, int)),
    "a structure for a number": lambda file: file.attrs.__setitem__("interrupted", np.zeros((), [("a", float)])),
    "a text for a number": lambda file: file.attrs.__setitem__("interrupted", "no"),
    "no number": lambda file: file.attrs.__delitem__("interrupted"),
    "no scenario": lambda file: file.__delitem__("scenario"),
    "a scenario of numbers": other("scenario", data=1.0),
    "a scenario that is not UTF-8": scenario(lambda data: b"\xff"),
    "a scenario of texts": other("scenario", data=["{}", "{}"]),
    "no JSON": scenario(lambda data: b"{"),
    "JSON of another kind": scenario(lambda data: [data]),
    "deep JSON": scenario(lambda data: b"[" * 100_000),
    "another format": scenario(lambda data: {**data, "format": 1}),
    "another arm": scenario(lambda data: {**data, "arm": {**data["arm"], "joints": data["arm"]["joints"][1:]}}),
    "a joint of no kind": scenario(lambda data: {**data, "arm": {**data["arm"], "joints": [{"kind": "hinge"}]}}),
    "an unknown law": scenario(lambda data: {**data, "law": {"kind": "__import__", "name": "os"}}),
    "a fault for a law": scenario(lambda data: {**data, "law": {"kind": "locked"}}),
    "a law without a kind": scenario(lambda data: {**data, "law": {}}),
    "an unknown setting": scenario(lambda data: {**data, "colour": "red"}),
    "a missing setting": scenario(lambda data: {key: value for key, value in data.items() if key != "task"}),
    "not a number": scenario(lambda data: {**data, "period": {"float": "nan"}}),
    "a number too large": scenario(lambda data: {**data, "start": [10**400] * 8}),
    "too few ticks": scenario(lambda data: {**data, "duration": 1.0}),
    "too many ticks": scenario(lambda data: {**data, "period": 1e-12}),
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS)
def test_a_file_that_was_edited_is_refused(spoiled, edit):
    path = spoiled(edit)
    with refused("path", "bad.nc", "run.save()"):
        Run.load(path)


def test_bytes_of_another_file_are_not_read(spoiled, tmp_path):
    secret = tmp_path / "secret"
    secret.write_bytes(np.arange(1000.0).tobytes())
    size = 8 * len(RUN)
    path = spoiled(other("damping", shape=(len(RUN),), dtype="f8", external=[(str(secret), 0, size)]))
    with refused("path", "damping"):
        Run.load(path)


def test_sizes_are_looked_at_before_memory_is_asked_for(tmp_path):
    with h5netcdf.File(tmp_path / "huge.nc", "w") as file:
        sizes = {"joint": 1, "row": 4, "column": 4, "component": 6}
        file.dimensions = {"time": 10**10, **sizes}
        for text in ("joint", "joint_unit"):
            file.create_variable(text, ("joint",), h5py.string_dtype())[...] = np.array(["rad"], object)
        file.create_variable("scenario", ("joint",), "S1")[...] = np.array([b"0"])
        for entry in FIELDS:
            chunks = (1000, *(sizes[axis] for axis in entry.axes))
            file.create_variable(entry.name, ("time", *entry.axes), entry.dtype, chunks=chunks)
    with refused("path", "80000000000", "time"):
        Run.load(tmp_path / "huge.nc")


def test_a_compressed_file_is_a_run(spoiled):
    def compress(file):
        for entry in FIELDS:
            if entry.name != "time":
                other(entry.name, data=file[entry.name][...], chunks=file[entry.name].shape, compression="gzip")(file)

    np.testing.assert_array_equal(Run.load(spoiled(compress)).q, RUN.q)


def test_spoiled_bytes_are_a_run_or_refused(good, tmp_path):
    rng, data, path, refused = random.Random(0), good.read_bytes(), tmp_path / "bad.nc", 0
    for _ in range(60):
        content = bytearray(data)
        for _ in range(rng.choice([1, 2, 5, 30])):
            content[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(content)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                Run.load(path)
            except sr.InputError:
                refused += 1
    assert refused > 5


@pytest.mark.parametrize("value", [3, None, "a\0b"])
def test_what_is_no_path_is_refused(value):
    with refused("path"):
        Run.load(value)
    with refused("path"):
        RUN.save(value)


def test_a_pipe_is_neither_read_nor_written(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileNotFoundError):
        Run.load(tmp_path / "pipe")
    with refused("path", "pipe"):
        RUN.save(tmp_path / "pipe")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("q", RUN.q + 1j),
        ("q", np.full(SHAPE, "a")),
        ("status", RUN.damping),
        ("health", np.full(SHAPE, 300)),
        ("q", [[1], [1, 2]]),
    ],
)
def test_arrays_whose_numbers_would_change_are_refused(name, value):
    with refused(name):
        replace(RUN, **{name: value})


FULL_DISK = """
import resource, sys
import stillreach as sr
run = sr.Run.load(sys.argv[1])
for size in range(0, int(sys.argv[3]), int(sys.argv[3]) // 24):
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    try:
        run.save(sys.argv[2])
    except OSError as error:
        assert error.filename == sys.argv[2], error
    else:
        sys.exit(f"saved with {size} bytes of room")
"""


def test_a_full_disk_is_an_error_and_leaves_the_old_file(good, tmp_path):
    """Wherever the room ends, HDF5 neither ends the process nor complains at its exit."""
    path = tmp_path / "a.nc"
    shutil.copy(good, path)
    command = [sys.executable, "-c", FULL_DISK, str(good), str(path), str(good.stat().st_size)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert path.read_bytes() == good.read_bytes()
    assert list(tmp_path.iterdir()) == [path]
