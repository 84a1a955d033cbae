"""Time of one control tick from Python, beside Pinocchio's Jacobian with NumPy's damped least squares.

Minima of interleaved repeats in one process on one core, averaged over many poses along short paths; reading
``out.rates`` included. Then the slowest of hostile ticks under every law (``hostile.py``). ``make bench`` prints both.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.hostile import TICKS, print_hostile
from bench.peers.pinocchio_numpy import Peer
from bench.timing import Row, machine_note, measure, pin_to_one_core
from bench.workload import OVER, Workload, controller, robot, workload
from stillreach import _core

LAWS: dict[str, tuple[sr.Law, tuple[float, float, float] | None]] = {
    "Pseudoinverse": (sr.Pseudoinverse(), (0.6, 1.5, 2.0)),
    "SingularityRobust, exact, over the limit": (sr.SingularityRobust(damping="exact"), (4.0, 5.0, 5.5)),
    "SingularityRobust, closed form, over the limit": (sr.SingularityRobust(damping="closed-form"), None),
    "LeastError, limits biting": (sr.LeastError(), (1.8, np.inf, 3.0)),
    "LeastError(price=None), limits biting": (sr.LeastError(price=None), (1.8, np.inf, 3.0)),
    "KeepDirection, limits biting": (sr.KeepDirection(), (4.0, np.inf, np.inf)),
}
COLD = {"LeastError, limits biting": 4.0, "LeastError(price=None), limits biting": 4.0}

STARTUP_BUDGET = 60.0
STARTUP = """
import time, numpy as np
began = time.perf_counter()
import stillreach as sr
ctl = sr.Controller(sr.arms.nasa_modular())
ctl.step(np.linspace(0.1, 1.1, 11), np.array([0.1, 0, 0, 0, 0, 0])).rates
print(1e3 * (time.perf_counter() - began))
"""


def bound_ticks(law: sr.Law, work: Workload) -> Callable[[slice], None]:
    """One tick() for each row, bound once; the rates are in `rates` when it returns."""
    ctl, rates = controller(law), np.zeros(work.q.shape[1])
    ticks = [ctl.bind(q=q, twist=twist, rates=rates) for q, twist in zip(work.q, work.twist, strict=True)]

    def run(part: slice) -> None:
        for tick in ticks[part]:
            tick()

    return run


def steps(law: sr.Law, work: Workload, out: np.ndarray | None, *, cold: bool = False) -> Callable[[slice], None]:
    """ctl.step for each row, with an array to write to or a new one each; cold: nothing is known of the last tick."""
    ctl = controller(law)
    rows = list(zip(list(work.q), list(work.twist), strict=True))
    step, reset = ctl.step, ctl.reset

    def new(part: slice) -> None:
        for q, twist in rows[part]:
            step(q, twist).rates  # noqa: B018 - reading them is part of the work

    def given(part: slice) -> None:
        for q, twist in rows[part]:
            step(q, twist, out=out).rates  # noqa: B018

    def from_nothing(part: slice) -> None:
        for q, twist in rows[part]:
            reset()
            step(q, twist).rates  # noqa: B018

    return from_nothing if cold else new if out is None else given


def resets() -> Callable[[slice], None]:
    """ctl.reset alone."""
    reset = controller(sr.LeastError()).reset

    def run(part: slice) -> None:
        for _ in range(part.start, part.stop):
            reset()

    return run


def fail_and_restore() -> Callable[[slice], None]:
    """A joint fails and comes back, by name."""
    ctl = controller(sr.LeastError())
    fail, restore = ctl.fail, ctl.restore

    def run(part: slice) -> None:
        for _ in range(part.start, part.stop):
            fail("j6")
            restore("j6")

    return run


def pinocchio() -> Peer:
    """Pinocchio and NumPy, without a limit to scale down to."""
    with tempfile.TemporaryDirectory() as folder:
        return Peer(robot(Path(folder), limit=np.inf))


def peer_ticks(work: Workload) -> Callable[[slice], None]:
    """Pinocchio and NumPy on every row."""
    tick, rows = pinocchio().tick, list(zip(list(work.q), list(work.twist), strict=True))

    def run(part: slice) -> None:
        for q, twist in rows[part]:
            tick(q, twist)

    return run


def make_rows(work: Workload) -> list[Row]:
    """Everything that is measured; the peer comes first."""
    out = np.zeros(work.q.shape[1])
    rows = [Row("Pinocchio + NumPy damped least squares", "-", peer_ticks(work))]
    reset = Row("reset", "-", resets())
    for name, (law, budgets) in LAWS.items():
        bound, given, new = budgets or (np.inf, np.inf, np.inf)
        rows.append(Row(name, "bound", bound_ticks(law, work), bound))
        rows.append(Row(name, "out=", steps(law, work, out), given))
        rows.append(Row(name, "new array", steps(law, work, None), new))
        if name in COLD:
            cold = steps(law, work, None, cold=True)
            rows.append(Row(f"{name}, cold", "new array", cold, COLD[name], less=reset))
    rows.append(reset)
    rows.append(Row("fail, then restore", "pair", fail_and_restore(), 4.0))
    return rows


def startup(repeats: int = 9) -> list[float]:
    """[ms] of `import stillreach` and the first tick in a fresh process that has imported NumPy."""
    command = [sys.executable, "-c", STARTUP]
    return sorted(
        float(subprocess.run(command, capture_output=True, text=True, check=True).stdout) for _ in range(repeats)
    )


def same_answers(work: Workload) -> float:
    """Largest relative difference between the peer's rates and Pseudoinverse's: both do the same work."""
    peer, ctl = pinocchio(), controller(sr.Pseudoinverse())
    pairs = [(peer.tick(q, t).copy(), ctl.step(q, t).rates) for q, t in zip(work.q, work.twist, strict=True)]
    return max(float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in pairs)


def budget_text(value: float | None, measured: float) -> str:
    """The budget, and by how much it is missed."""
    if value is None or not np.isfinite(value):
        return "-"
    return f"{value:g}" + ("" if measured <= value else f" (over by {100 * (measured / value - 1):.0f} %)")


def print_table(rows: list[Row]) -> None:
    """Markdown; times in µs a call."""
    peer = rows[0]
    print("| tick, 11 joints, 3 failed | call | min [µs] | median [µs] | budget [µs] | peer / this |")
    print("|---|---|---:|---:|---:|---:|")
    for row in rows:
        ratio = f"{peer.best / row.best:.1f}" if row.way in ("bound", "out=", "new array") else "-"
        budget = budget_text(row.budget, row.best)
        print(f"| {row.name} | {row.way} | {row.best:.2f} | {row.median:.2f} | {budget} | {ratio} |")


def print_startup(times: list[float]) -> None:
    """[ms], sorted."""
    budget = budget_text(STARTUP_BUDGET, times[0])
    middle = times[len(times) // 2]
    print("\nimport stillreach + first tick, over importing NumPy:", end=" ")
    print(f"min {times[0]:.1f} ms, median {middle:.1f} ms; budget {budget} ms.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=15.0, help="how long the ticks are timed")
    parser.add_argument("--hostile", type=int, default=TICKS, help="hostile ticks for each law; 0: none")
    given = parser.parse_args()
    seconds = given.seconds
    cores = pin_to_one_core()
    work = workload(OVER)
    rows = make_rows(work)
    before = machine_note(cores)
    repeats = measure(rows, seconds)
    print_table(rows)
    print_startup(startup())
    if given.hostile:
        print_hostile(given.hostile)
    print(
        f"{repeats} interleaved repeats of {len(work)} ticks on one core; the pseudoinverse is {OVER:g} times over the"
    )
    print(f"limit in each. Peer and Pseudoinverse differ by {same_answers(work):.0e}. Budgets are for a quiet core.")
    print(f"Kernel for {_core.instruction_set()}. Before: {before} After: {machine_note(cores)}")


if __name__ == "__main__":
    main()
