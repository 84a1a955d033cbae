"""The WebAssembly controller is the baseline build, bit for bit; what it says of an arm is what Python says."""

import json
import os
import shutil
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from stillreach.page.pack import pack
from stillreach.page.task import task_of
from stillreach.simulation.record import FIELDS
from tests.unit.page.cases import ARRAYS, LAWS, START, WAYS

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "page"
HERE = Path(__file__).parent
NODE = shutil.which("node") or shutil.which("node", path=str(Path(sys.executable).parent))
TICKS = 2500
needs_node = pytest.mark.skipif(NODE is None, reason="needs Node.js to run WebAssembly")


def node(script, folder):
    done = subprocess.run([NODE, HERE / script, PAGE, folder], check=False, text=True, capture_output=True, timeout=100)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    folder = tmp_path_factory.mktemp("played")
    environment = os.environ | {"STILLREACH_INSTRUCTIONS": "baseline"}
    subprocess.run([sys.executable, HERE / "cases.py", folder, str(TICKS)], check=True, env=environment, timeout=100)
    assert node("play.mjs", folder)["ticks"] >= 100_000
    return folder


@needs_node
@pytest.mark.xdist_group("played")
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("law", LAWS)
def test_a_played_task_is_the_run_on_the_baseline_to_the_last_bit(played, law, way):
    name = f"{law}, {way}".replace(" ", "-")
    with np.load(played / f"{name}.npz") as run:
        assert len(run["q"]) == TICKS + 1
        for field in FIELDS:
            if field.name in ARRAYS:
                assert (played / f"{name}.{field.name}").read_bytes() == run[field.name].tobytes(), field.name


@needs_node
def test_a_motion_that_waits_for_the_arm_waits_in_the_page_too(tmp_path):
    line = sr.Line([0.1, 0.1, -0.1], duration=1.0, relative=True)
    task = sr.Scenario(
        arm=sr.arms.panda(),
        start=START,
        motion=line,
        clock="arm",
        duration=4.0,
        velocity_limits=0.2,
        law=sr.KeepDirection(),
    )
    run = sr.simulate(task, progress=False)
    assert run.path_time[100] < 0.6  # it does wait
    document, block = pack({"task": task_of(task, planned=True)[0]})
    (tmp_path / "waits.json").write_text(document, encoding="utf-8")
    (tmp_path / "waits.b64").write_text(block, encoding="utf-8")
    (tmp_path / "names.txt").write_text("waits", encoding="utf-8")
    node("play.mjs", tmp_path)
    pose = np.frombuffer((tmp_path / "waits.pose").read_bytes()).reshape(-1, 4, 4)
    np.testing.assert_allclose(pose[:, :3, 3], run.pose[:, :3, 3], atol=0.002)  # of 173 mm, in open loop


def test_the_webassembly_is_made_of_the_headers_as_they_are():
    spec = spec_from_file_location("wasm", ROOT / "scripts" / "wasm.py")
    wasm = module_from_spec(spec)
    spec.loader.exec_module(wasm)
    assert wasm.MADE_OF.read_text().strip() == wasm.made_of(), "build it again: make wasm"


def resting(arm, q, rows, broken):
    held = sr.ConstantTwist([0.0] * 6)
    scenario = sr.Scenario(arm=arm, start=q, motion=held, duration=0.01, task=sr.Task(rows=rows), allow_outside=True)
    return {**task_of(scenario, planned=False)[0], "broken": broken}


@needs_node
def test_what_the_page_says_of_an_arm_is_what_its_report_says(tmp_path):
    rng = np.random.default_rng(5)
    cases = []
    for arm in (sr.arms.panda(), sr.arms.snake(9), sr.arms.planar(4), sr.arms.nasa_modular()):
        for _ in range(6):
            q = rng.uniform(-1.5, 1.5, arm.n)
            for broken in ([], [int(rng.integers(arm.n))]):
                rows = (True, True, False, False, False, False) if arm.n == 4 else "pose"
                cases.append((arm, q, rows, broken))
    document, block = pack([resting(*case) for case in cases])
    (tmp_path / "looks.json").write_text(document, encoding="utf-8")
    (tmp_path / "looks.b64").write_text(block, encoding="utf-8")
    for (arm, q, rows, broken), said in zip(cases, node("look.mjs", tmp_path), strict=True):
        report = sr.tolerance.report(arm, q, k=1, task=sr.Task(rows=rows), failed=broken)
        m = len(report.task.indices)
        working = [i for i in range(arm.n) if i not in broken]
        assert said["lost"] == m - report.rank
        np.testing.assert_allclose(np.array(said["relative"])[working], report.relative[0], atol=2e-7)
        assert [said["costs"][i] > 0 for i in working] == report.loses[0].tolist()
        for place, joint in enumerate(working):
            if report.loses[0][place]:
                lost, cost = report.lost_directions([joint]), np.array(said["cost"]).reshape(-1, 6)[joint]
                inside = lost.T @ (lost @ cost[list(report.task.indices)])
                np.testing.assert_allclose(np.linalg.norm(inside), 1.0, atol=1e-6)
        rates = np.where(np.isfinite(arm.velocity_limits), arm.velocity_limits, 1.0)[working]
        sigma = np.linalg.svd(arm.jacobian(q)[:3, working] * rates, compute_uv=False)
        np.testing.assert_allclose(said["sigma"], np.pad(sigma, (0, 3 - len(sigma))), atol=1e-9)
        np.testing.assert_allclose(np.reshape(said["drawn"], (4, 4)), arm.forward(q), atol=1e-12)
        np.testing.assert_allclose(np.reshape(said["pose"], (4, 4)), arm.forward(q), atol=1e-12)
