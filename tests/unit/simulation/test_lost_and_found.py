"""What an interrupt or a kill must not destroy."""

import os
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation import netcdf
from tests.unit.simulation.scenarios import small_run

SCENARIO = """
import sys, numpy as np, stillreach as sr
def motion(t):
    if 1.5 < t < 1.51: print("under way", flush=True)
    return [0.1 * np.cos(t), 0.1 * np.sin(t), 0, 0, 0, 0.1]
def scenario(duration):
    arm = sr.arms.nasa_modular()
    start = np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0])
    fault = sr.Fault("j3", at=0.3)
    return sr.Scenario(arm=arm, start=start, motion=motion, faults=[fault], law=sr.SingularityRobust(), period=1e-3,
    duration=duration)
"""


def test_ctrl_c_keeps_every_tick_that_was_computed(tmp_path):
    code = (
        SCENARIO
        + "try:\n    sr.simulate(scenario(300.0))\n"
        + "except sr.errors.SimulationInterrupted as stopped:\n    stopped.run.save(sys.argv[1])\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "part.nc")], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "under way\n"
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=60)
    assert child.returncode == 0

    part = sr.Run.load(tmp_path / "part.nc")
    assert part.interrupted
    assert 300 < len(part) < 300_001
    namespace = {}
    exec(SCENARIO.replace('print("under way", flush=True)', "pass"), namespace)
    whole = sr.simulate(namespace["scenario"](part.time[-1]))
    assert len(whole) == len(part)
    for name in ("time", "q", "rates", "pose", "status", "health"):
        assert np.array_equal(getattr(part, name), getattr(whole, name)), name


def test_an_interrupt_that_nobody_catches_ends_the_program_like_any_ctrl_c():
    child = subprocess.Popen(
        [sys.executable, "-c", SCENARIO + "sr.simulate(scenario(300.0))"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout.readline() == "under way\n"
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=60)
    assert child.returncode != 0
    assert "SimulationInterrupted" in said


def _save_for_ever(run, path):
    """In a child process: announce the first save, then save until killed."""
    try:
        while True:
            run.save(path)
    finally:
        os._exit(1)


def test_ctrl_c_during_a_save_waits_until_the_file_stands(tmp_path, monkeypatch):
    run, fill = small_run(), netcdf._fill

    def interrupted(*arguments):
        signal.raise_signal(signal.SIGINT)
        fill(*arguments)

    monkeypatch.setattr(netcdf, "_fill", interrupted)
    handler = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        run.save(tmp_path / "run.nc")
    assert signal.getsignal(signal.SIGINT) is handler
    assert np.array_equal(sr.Run.load(tmp_path / "run.nc").q, run.q)
    assert [file.name for file in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork, which this system does not have")
def test_a_killed_save_leaves_the_old_file_whole(tmp_path):
    old, path = small_run(), tmp_path / "run.nc"
    new = small_run(period=3e-4)
    left = set()
    for trial in range(6):
        old.save(path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12 on: other threads; the child uses none
            child = os.fork()
        if child == 0:
            _save_for_ever(new, path)
        time.sleep(0.05 + 0.05 * trial)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        found = sr.Run.load(path)
        assert len(found) in (len(old), len(new))
        assert np.array_equal(found.q, (old if len(found) == len(old) else new).q)
        left |= {file.name for file in tmp_path.iterdir()} - {"run.nc"}
    # without a name until it is complete: then it has one for the moment in which it takes the old one's place
    assert len(left) <= (1 if hasattr(os, "O_TMPFILE") else 6)


def test_a_save_that_fails_leaves_nothing_behind(tmp_path):
    run = small_run()
    with pytest.raises(FileNotFoundError) as caught:
        run.save(tmp_path / "no such folder" / "run.nc")
    assert caught.value.filename == str(tmp_path / "no such folder" / "run.nc")
    (tmp_path / "taken").mkdir()
    with pytest.raises(OSError, match="taken"):
        run.save(tmp_path / "taken")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
