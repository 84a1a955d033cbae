"""What recording costs a loop: a tick of add(), and how late a loop of 1 kHz is with and without a recorder.

A Panda on a circle. add(): minimum of the means of 1,000 calls. Loop: sleeps until its next tick, as loops in Python
do; lateness is how long after its time a tick begins.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.timing import machine_note

PERIOD = 0.001
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])


def cost(folder: Path) -> tuple[float, sr.Recorder]:
    """[us] of add()."""
    arm = sr.arms.panda()
    controller, pose = sr.Controller(arm, period=PERIOD), arm.forward(START)
    controller.track(START, pose)
    best = np.inf
    with sr.Recorder(folder / "tight.rosbag2", controller) as recorder:
        for _ in range(20):
            began = time.perf_counter()
            for _ in range(1000):
                recorder.add(START, pose)
            best = min(best, 1e3 * (time.perf_counter() - began))
            time.sleep(0.3)
    return best, recorder


def lateness(seconds: float, path: Path | None) -> np.ndarray:
    """[ms] of each tick of a loop."""
    arm = sr.arms.panda()
    controller, centre, q = sr.Controller(arm, period=PERIOD), arm.forward(START), START.copy()
    late = np.empty(round(seconds / PERIOD))
    recorder = None if path is None else sr.Recorder(path, controller)
    rates, target, twist = np.zeros(7), centre.copy(), np.zeros(6)
    tick = controller.bind(q=q, twist=twist, rates=rates, target=target)
    began = time.perf_counter()
    for k in range(len(late)):
        wait = began + k * PERIOD - time.perf_counter()
        if wait > 0.0:
            time.sleep(wait)
        late[k] = 1e3 * (time.perf_counter() - began - k * PERIOD)
        target[0, 3] = centre[0, 3] + 0.05 * np.sin(0.001 * k)
        tick()
        if recorder is not None:
            recorder.add(q, target)
        q += PERIOD * rates
    if recorder is not None:
        recorder.close()
        assert recorder.written == len(late)
    return late


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0, help="of each loop (default 20)")
    seconds = parser.parse_args().seconds
    with tempfile.TemporaryDirectory() as folder:
        each, recorder = cost(Path(folder))
        print(f"add(): {each:.2f} us a tick; {recorder.bytes_per_hour / 1e6:,.0f} MB an hour at 1 kHz")
        print(f"{'lateness of a 1 kHz loop [ms]':32}{'median':>9}{'99 %':>9}{'worst':>9}")
        for name, path in (("without a recorder", None), ("with one", Path(folder) / "loop.rosbag2")):
            late = lateness(seconds, path)
            print(f"{name:32}{np.median(late):9.3f}{np.percentile(late, 99):9.3f}{late.max():9.3f}")
    print(machine_note(2))


if __name__ == "__main__":
    main()
