"""Time of a simulated tick in WebAssembly (node), beside the native instruction sets, on the same commands.

Tracking with recording, 128 ticks from the same start in one call; minima of 300 calls, the sets one after the other.
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

import stillreach as sr
from bench.timing import machine_note
from stillreach import _core
from stillreach.page.pack import pack
from stillreach.page.task import task_of
from stillreach.simulation.orders import parts_of
from stillreach.simulation.record import empty_record

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


def main() -> None:
    node = shutil.which("node") or shutil.which("node", path=str(Path(sys.executable).parent))
    if node is None:
        sys.exit("bench.wasm needs Node.js")
    measured = {}
    for name in SETS:
        environment = os.environ | {"STILLREACH_INSTRUCTIONS": name}
        done = subprocess.run(
            [sys.executable, "-m", "bench.wasm", "native"], env=environment, capture_output=True, check=True
        )
        measured[name] = json.loads(done.stdout)
    with tempfile.TemporaryDirectory() as folder:
        document, block = pack([task_of(scenario, planned=True)[0] for scenario in scenarios().values()])
        (Path(folder) / "tasks.json").write_text(document, encoding="utf-8")
        (Path(folder) / "tasks.b64").write_text(block, encoding="utf-8")
        script = [node, ROOT / "bench" / "wasm.mjs", ROOT / "page", folder]
        measured["WebAssembly"] = json.loads(subprocess.run(script, capture_output=True, check=True).stdout)
    print(f"us a tick; in brackets, WebAssembly over it\n{'':26}" + "".join(f"{name:>16}" for name in measured))
    for place, name in enumerate(scenarios()):
        wasm = measured["WebAssembly"][place]
        print(
            f"{name:26}" + "".join(f"{times[place]:8.2f} ({wasm / times[place]:4.2f})" for times in measured.values())
        )
    print(machine_note(len(os.sched_getaffinity(0))))


if __name__ == "__main__":
    if sys.argv[1:] == ["native"]:
        print(json.dumps(native()))
    else:
        main()
