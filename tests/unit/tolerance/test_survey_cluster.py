"""A survey on a Dask cluster of two processes is that of this process, whatever happens to a worker."""

import os
import signal
import threading
import time

import pytest

import stillreach as sr
from stillreach import InputError
from stillreach.tolerance.surveys import run
from stillreach.tolerance.surveys.store import Build
from tests.commands import run_command

zarr = pytest.importorskip("zarr", reason="needs the extra survey")
distributed = pytest.importorskip("distributed", reason="needs the extra survey")
pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.xdist_group("cluster")]

ARM = sr.arms.nasa_modular()
SETTINGS = {"samples": 12_000, "k": 3, "chunk": 500, "seed": 11, "metrics": "depth"}


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes with nannies on loopback."""
    made = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None
    )
    with distributed.Client(made) as client:
        yield client
        made.scale(0)  # workers first: they would look for a scheduler that is gone
        deadline = time.monotonic() + 20.0
        while made.workers and time.monotonic() < deadline:
            time.sleep(0.05)
    made.close()


def contents(path):
    group = zarr.open_group(str(path), mode="r", zarr_format=2)
    return dict(group.attrs), {name: array[...] for name, array in group.arrays()}


def kill_one(process, folder, killed):
    """Kills a worker's process once two chunks are stored."""
    while True:
        done = list((folder / "done").glob("[0-9]*")) if (folder / "done").is_dir() else []
        if len(done) >= 2:
            break
        time.sleep(0.002)
    os.kill(process, signal.SIGKILL)
    killed.append(len(done))


def test_a_killed_worker_changes_nothing(cluster, tmp_path):
    """Workers that are new take the baseline, also the one that replaces the killed one."""
    killed, process = [], next(iter(cluster.run(os.getpid).values()))
    thread = threading.Thread(target=kill_one, args=(process, tmp_path / "cluster", killed), daemon=True)
    thread.start()
    found = sr.tolerance.survey(ARM, tmp_path / "cluster", client=cluster, baseline=True, **SETTINGS)
    thread.join(10.0)
    assert found.complete
    assert killed
    assert killed[0] < SETTINGS["samples"] // SETTINGS["chunk"]
    embedded = sr.tolerance.survey(ARM, tmp_path / "here", baseline=True, **SETTINGS)
    (attributes, one), (others, two) = contents(found.path), contents(embedded.path)
    assert attributes == others
    assert attributes["instruction_set"] == "baseline"
    assert one.keys() == two.keys()
    for name in one:
        assert one[name].tobytes() == two[name].tobytes(), name


def test_the_command_takes_a_scheduler(cluster, tmp_path):
    address = cluster.scheduler.address
    options = ["--samples", "400", "--chunk", "100", "-k", "1", "--metric", "depth", "--no-plot", "--baseline"]
    done = run_command("survey", "panda", *options, "--scheduler", address, folder=tmp_path)
    assert done.code == 0, done.err
    assert "400 configurations of panda" in done.out
    assert sr.tolerance.Survey.load(tmp_path / "out" / "panda" / "survey.zarr").configurations == 400


def test_workers_of_another_instruction_set_are_refused(cluster, tmp_path):
    """These have computed with the baseline, and cannot change it."""
    if Build.here().instructions == "baseline":
        pytest.skip("this machine has the baseline alone")
    said = r"client: got tcp://.*, which has stillreach .* with baseline on .*, expected .* with avx2"
    with pytest.raises(InputError, match=said):
        sr.tolerance.survey(ARM, tmp_path / "x", client=cluster, **SETTINGS)


def test_other_versions_are_refused():
    here = Build("9.2", "avx2", "x86_64")
    for other in (
        here._replace(version="9.1"),
        here._replace(instructions="baseline"),
        here._replace(machine="arm64"),
    ):
        with pytest.raises(InputError, match=f"client: got tcp://a:1, which has {other}, expected {here}"):
            run._check("tcp://a:1", other, here)
    run._check("tcp://a:1", here, here)
