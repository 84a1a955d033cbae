"""Runs as NumPy archives: what was saved comes back, and what is no run is refused."""

import io
import json
import sys
import zipfile

import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation import archive
from stillreach.simulation.document import scenario_text
from stillreach.simulation.record import FIELDS
from tests.refusals import refused
from tests.unit.simulation.scenarios import first_ticks


@pytest.fixture
def run():
    faults = [sr.Fault("j1", at=0.05, kind=sr.Derated(0.5))]
    motion = sr.ConstantTwist([0.1, 0, 0, 0, 0, 0], 0.1)
    return sr.simulate(
        sr.Scenario(arm=sr.arms.planar(3), start=[0.1, 0.8, 0.5], motion=motion, faults=faults, name="π")
    )


def same(a, b):
    for field in FIELDS:
        one, other = getattr(a, field.name), getattr(b, field.name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    assert (a.joint_names, a.interrupted) == (b.joint_names, b.interrupted)
    assert scenario_text(a.scenario) == scenario_text(b.scenario)


def test_an_archive_needs_no_extra_and_holds_what_a_netcdf_file_holds(run, tmp_path, monkeypatch):
    run.save(tmp_path / "run.nc")
    from_netcdf = sr.Run.load(tmp_path / "run.nc")
    for name in ("h5netcdf", "h5py", "xarray"):
        monkeypatch.setitem(sys.modules, name, None)
    run.save(tmp_path / "run.npz")
    same(sr.Run.load(tmp_path / "run.npz"), run)
    same(sr.Run.load(tmp_path / "run.npz"), from_netcdf)
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", "run.npz"}


def test_an_archive_is_known_by_its_content_and_an_empty_run_is_one(run, tmp_path):
    empty = first_ticks(run, 0)
    empty.save(str(tmp_path / "run.npz"))
    (tmp_path / "run.npz").rename(tmp_path / "renamed")
    same(sr.Run.load(tmp_path / "renamed"), empty)


def test_a_file_of_that_name_is_replaced_whole_or_not_at_all(run, tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    run.save(path)
    monkeypatch.setattr(np, "savez_compressed", lambda file, **arrays: file.write(b"half") and 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run.save(path)
    same(sr.Run.load(path), run)
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.npz"]


def zipped(**entries):
    """An archive of raw entries."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as file:
        for name, content in entries.items():
            file.writestr(name, content)
    return data.getvalue()


def changed(path, **arrays):
    """The bytes of an archive with other arrays in it; None leaves one out."""
    with np.load(path) as stored:
        content = {**stored, **arrays}
    data = io.BytesIO()
    np.savez(data, **{name: array for name, array in content.items() if array is not None})
    return data.getvalue()


SPOILED = {
    "nothing": lambda path: b"",
    "text": lambda path: b"time,q\n1,2\n",
    "half a file": lambda path: path.read_bytes()[:500],
    "another archive": lambda path: zipped(notes="hello"),
    "no array": lambda path: zipped(**{f"{field.name}.npy": "x" for field in FIELDS}),
    "a missing array": lambda path: changed(path, rates=None),
    "no scenario": lambda path: changed(path, scenario=None),
    "a scenario that is no JSON": lambda path: changed(path, scenario="{"),
    "a scenario of another kind": lambda path: changed(path, scenario=json.dumps([1])),
    "a list for a number": lambda path: changed(path, interrupted=[0, 1]),
    "an array of another length": lambda path: changed(path, time=np.zeros(3)),
    "text for numbers": lambda path: changed(path, time=np.array(["a"] * 11)),
    "a joint too many": lambda path: changed(path, joint=np.array(list("abcd"))),
}


@pytest.mark.parametrize("spoil", SPOILED.values(), ids=SPOILED)
def test_what_is_no_run_is_refused(run, tmp_path, spoil):
    path = tmp_path / "run.npz"
    run.save(path)
    path.write_bytes(spoil(path))
    with pytest.raises(sr.InputError):
        sr.Run.load(path)


def test_an_array_of_python_objects_is_not_unpickled(run, tmp_path):
    path = tmp_path / "run.npz"
    run.save(path)
    path.write_bytes(changed(path, scenario=np.array([{"a": 1}], dtype=object)))
    with pytest.raises(sr.InputError, match="allow_pickle"):
        sr.Run.load(path)


def test_sizes_are_looked_at_before_anything_is_read(run, tmp_path, monkeypatch):
    run.save(tmp_path / "run.npz")
    monkeypatch.setattr(archive, "LARGEST", 1000)
    with refused("path", "1000"):
        sr.Run.load(tmp_path / "run.npz")


def test_a_file_that_is_not_there_is_missing(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.npz"):
        sr.Run.load(tmp_path / "none.npz")
