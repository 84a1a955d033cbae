"""The live page: a tick in WebAssembly beside the native instruction sets, and the time from the command to the screen.

Ticks (node): tracking with recording, 128 from the same start in one call; minima of 300 calls, the sets one after the
other. The screen: `stillreach view panda.urdf` as a process of its own, then its page in a running Chromium (software
WebGL) until the arm is drawn; the slowest of five.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

import stillreach as sr
from bench.timing import machine_note
from stillreach import _core
from stillreach.page.pack import pack
from stillreach.page.task import task_of
from stillreach.simulation.orders import parts_of
from stillreach.simulation.record import empty_record
from tests.browser import chromium

ROOT = Path(__file__).parents[1]
SETS = ("baseline", "avx2", "avx512")
TICKS, REPEATS = 128, 300


def scenarios() -> dict[str, sr.Scenario]:
    rest = {"loop": "closed", "period": 0.001}
    panda, snake = sr.arms.panda(), sr.arms.snake(11)
    start = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
    slow, fast = (
        sr.ConstantTwist(size * np.array([0.1, 0.2, 0.05, 0.1, 0.0, 0.0]), duration=1.0) for size in (0.2, 9.0)
    )
    return {
        "Panda": sr.Scenario(arm=panda, start=start, motion=slow, **rest),
        "11 joints": sr.Scenario(arm=snake, start=0.3 * np.cos(np.arange(11)), motion=slow, **rest),
        "11 joints, limits biting": sr.Scenario(arm=snake, start=0.3 * np.cos(np.arange(11)), motion=fast, **rest),
    }


def native() -> list[float]:
    """Minima [us] on the instruction set of this process."""
    found = []
    for scenario in scenarios().values():
        part, controller = parts_of(scenario)[0], scenario.controller()
        record = empty_record(TICKS, scenario.arm.n)
        twists, targets = part.twists[:TICKS], _core.frames(np.ascontiguousarray(part.poses[:TICKS]))
        best = np.inf
        for _ in range(REPEATS):
            q = scenario.start.copy()
            began = time.perf_counter()
            controller.rollout(q, twists, targets, record=record)
            best = min(best, 1e6 * (time.perf_counter() - began) / TICKS)
        found.append(best)
    return found


def on_screen() -> str:
    """What it takes from the command to the picture."""
    times = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as library:
        robot, browser = Path(folder) / "panda.urdf", chromium(library)
        sr.arms.panda().to_urdf(robot)
        for _ in range(5):
            began = time.perf_counter()
            command = [sys.executable, "-m", "stillreach", "view", robot, "--no-browser", "--out", folder]
            subprocess.run(command, check=True, capture_output=True)
            written = time.perf_counter()
            tab = browser.new_page(viewport={"width": 1280, "height": 800})
            tab.goto((Path(folder) / "view.html").as_uri())
            tab.wait_for_function("() => window.stillreach?.viewer?.frames > 0")
            times.append((time.perf_counter() - began, written - began))
            tab.close()
        browser.close()
    total, command_alone = max(times)
    return f"stillreach view panda.urdf to the arm on screen: {total:.2f} s, {command_alone:.2f} s of it the command"


def main() -> None:
    node = shutil.which("node") or shutil.which("node", path=str(Path(sys.executable).parent))
    if node is None:
        sys.exit("bench.live needs Node.js")
    measured = {}
    for name in SETS:
        environment = os.environ | {"STILLREACH_INSTRUCTIONS": name}
        done = subprocess.run(
            [sys.executable, "-m", "bench.live", "native"], env=environment, capture_output=True, check=True
        )
        measured[name] = json.loads(done.stdout)
    with tempfile.TemporaryDirectory() as folder:
        document, block = pack([task_of(scenario, planned=True)[0] for scenario in scenarios().values()])
        (Path(folder) / "tasks.json").write_text(document, encoding="utf-8")
        (Path(folder) / "tasks.b64").write_text(block, encoding="utf-8")
        script = [node, ROOT / "bench" / "live.mjs", ROOT / "page", folder]
        measured["WebAssembly"] = json.loads(subprocess.run(script, capture_output=True, check=True).stdout)
    print(f"us a tick; in brackets, WebAssembly over it\n{'':26}" + "".join(f"{name:>16}" for name in measured))
    for place, name in enumerate(scenarios()):
        wasm = measured["WebAssembly"][place]
        print(
            f"{name:26}" + "".join(f"{times[place]:8.2f} ({wasm / times[place]:4.2f})" for times in measured.values())
        )
    print(on_screen())
    print(machine_note(len(os.sched_getaffinity(0))))


if __name__ == "__main__":
    if sys.argv[1:] == ["native"]:
        print(json.dumps(native()))
    else:
        main()
