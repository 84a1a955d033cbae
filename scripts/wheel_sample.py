"""What `scripts/wheels.py` runs under every wheel: prints the bits of many answers, or the time of a tick, as JSON."""

import hashlib
import json
import sys
import time

import numpy as np

import stillreach as sr

ROWS = 20_000
LAWS = [
    sr.Pseudoinverse(),
    sr.SingularityRobust(damping=0.05),
    sr.SingularityRobust(damping="closed-form"),
    sr.SingularityRobust(damping="exact"),
    sr.LeastError(),
    sr.LeastError(price=None),
    sr.LeastError(price="position-first"),
    sr.KeepDirection(),
]


def work(arm: sr.Arm, rows: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(11)
    return rng.uniform(*np.clip(arm.position_limits, -2.9, 2.9).T, (rows, arm.n)), rng.normal(size=(rows, 6)) * 0.4


def bits() -> dict[str, str]:
    """One hash a law: of the rates of 20,000 ticks of two arms with a locked and a slow joint."""
    found = {}
    for law in LAWS:
        digest = hashlib.sha256()
        for arm in (sr.arms.panda(), sr.arms.nasa_modular()):
            q, twist = work(arm, ROWS // 2)
            bounds = sr.Bounds.symmetric(0.8, n=arm.n).lock([2])
            digest.update(sr.solve_batch(arm, law, q, twist, bounds).rates.tobytes())
            ctl = sr.Controller(arm, law=law, period=0.01)
            ctl.fail(1, sr.Derated(0.4))
            for at, wanted in zip(q[:300], twist[:300], strict=True):
                digest.update(ctl.step(at, wanted).rates.tobytes())
        found[repr(law)] = digest.hexdigest()
    return found


def times() -> dict[str, float]:
    """Minima of repeats [µs]: a tick from Python, bound once, and a row of a batch on one thread."""
    arm = sr.arms.panda()
    q, twist = work(arm, 500)
    out = np.zeros(arm.n)
    ctl = sr.Controller(arm, period=0.01)
    ticks = [ctl.bind(q=at, twist=wanted, rates=out) for at, wanted in zip(q, twist, strict=True)]
    best = {"tick": np.inf, "batch": np.inf}
    for _ in range(40):
        began = time.perf_counter()
        for tick in ticks:
            tick()
        best["tick"] = min(best["tick"], time.perf_counter() - began)
        began = time.perf_counter()
        sr.solve_batch(arm, sr.LeastError(), q, twist, sr.Bounds.symmetric(0.8, n=arm.n), threads=1)
        best["batch"] = min(best["batch"], time.perf_counter() - began)
    return {name: 1e6 * value / len(q) for name, value in best.items()}


if __name__ == "__main__":
    print(json.dumps({"bits": bits, "times": times}[sys.argv[1]]()))
