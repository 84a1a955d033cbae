"""Loops through faults beside a box QP, with acceleration limits, stretched out, and the paper's example 2."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

import stillreach as sr
from bench.tracking.loop import QP_DAMPING, Path, Record, Step, by_box_qp, by_law, circle, follow
from bench.tracking.setting import BARE, ELBOW, LAWS, PANDA_START, RATE, Claim, Machine, Part, table
from stillreach.paper import examples, measure

PERIOD, SECONDS, RESTORED = 0.01, 20.0, 14.0
"""[s] of the loops through faults."""
STARTED = 2.0
"""[s] By then the snake is stretched; before, joints may turn round once as it unrolls."""
ACCELERATION = 10.0
"""[rad/s²]"""
Events = dict[int, list[Callable[[sr.Controller], None]]]
STARTS = {"Panda": PANDA_START, "iiwa 14": np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0])}
"""[rad] Bent, amid the joints' ranges."""
FAULTS = (sr.Locked(), sr.Derated(0.3), sr.Runaway(0.1))


def through_faults(machines: list[Machine], loops: int = 20) -> Part:
    """Loops with faults between 1 and 12 s that are restored at 14 s."""
    solvers: dict[str, tuple[sr.Law | None, Step]] = {
        "80, the default": (None, by_law),
        "None, the bare optimum": (BARE, by_law),
        f"box QP, damping {QP_DAMPING:g}": (None, by_box_qp),
    }
    rows, claims = [], []
    for each in machines:
        final, flips = {}, {}
        for name, (law, step) in solvers.items():
            records = [loop(each, law, step, seed) for seed in range(loops)]
            final[name] = np.array([1e3 * record.off[-1] for record in records])
            variation = np.array([record.variation for record in records])
            flips[name] = np.array([record.sign_changes(0.5 * each.limits) for record in records])
            cells = [f"{np.median(v):.3g} / {np.max(v):.4g}" for v in (final[name], variation, flips[name])]
            rows.append((each.name, name, *cells))
        ours, theirs = (float(np.median(final[name])) for name in (next(iter(solvers)), list(solvers)[-1]))
        text = f"{each.name}: final error {ours:.3g} mm, at most twice the box QP's {theirs:.3g} (medians)"
        claims.append(Claim(text, ours <= 2.0 * theirs))
        most = int(np.max(flips["80, the default"]))
        claims.append(Claim(f"{each.name}: {most} sign changes above half of a limit", most == 0))
    head = ("arm", "solver", "final error mm: median / worst", "variation of the rates rad/s", "sign changes")
    return table(head, rows), claims


def loop(each: Machine, law: sr.Law | None, step: Step, seed: int) -> Record:
    """One of them: the same start, path and faults for every solver."""
    random = np.random.default_rng([seed, 21])
    q, ticks = STARTS[each.name] + random.uniform(-0.4, 0.4, each.arm.n), round(SECONDS / PERIOD)
    pace, shift = 2.0 * np.pi / random.uniform(5.0, 12.0, 6), random.uniform(-np.pi, np.pi, 6)
    size, turn = random.uniform(0.03, 0.12, 3), random.uniform(-0.3, 0.3, 3)
    path = Path(each.arm.forward(q), size, turn, pace, shift)
    ctl = sr.Controller(each.arm, law=law, period=PERIOD, velocity_limits=each.limits)
    return follow(ctl, q, path, ticks, PERIOD, events=faults(random, each.arm.n), step=step)


def faults(random: np.random.Generator, n: int) -> Events:
    """One to three joints fail; all are restored."""
    events: Events = {round(RESTORED / PERIOD): []}
    for joint in random.permutation(n)[: random.integers(1, 4)]:
        kind, begin = FAULTS[random.integers(len(FAULTS))], round(random.uniform(1.0, 12.0) / PERIOD)
        events.setdefault(begin, []).append(partial(sr.Controller.fail, joint=int(joint), kind=kind))
        events[round(RESTORED / PERIOD)].append(partial(sr.Controller.restore, joint=int(joint)))
    return events


def accelerating(each: Machine) -> Part:
    """A circle with acceleration limits beside the same without."""
    rows, claims = [], []
    for period in (0.001, 0.002, 0.01):
        tools = []
        for limit in (np.inf, ACCELERATION):
            ctl = sr.Controller(each.arm, period=period, velocity_limits=each.limits, acceleration_limits=limit)
            path = circle(each.arm.forward(PANDA_START))
            tools.append(follow(ctl, PANDA_START, path, round(8.0 / period), period))
        apart = 1e3 * np.linalg.norm(tools[0].tool - tools[1].tool, axis=1)
        rows.append((f"{1e3 * period:g}", *(f"{1e3 * np.max(t.off):.3f}" for t in tools), f"{np.max(apart):.3f}"))
        text = f"{1e3 * period:g} ms: {np.max(apart):.3f} mm from the unlimited circle, at most 1"
        claims.append(Claim(text, float(np.max(apart)) <= 1.0))
    head = ("period ms", "worst off mm, no limit", f"{ACCELERATION:g} rad/s²", "apart mm")
    return table(head, rows), claims


def giving_way(each: Machine) -> Part:
    """The circle, 20 ms, with joints locked at 2 s: what gives way at which prices."""
    rows, claims, period = [], [], 0.02
    for locked in ((ELBOW,), (ELBOW, ELBOW - 1)):
        for name, law in LAWS.items():
            ctl = sr.Controller(each.arm, law=law, period=period, velocity_limits=each.limits)
            events: Events = {100: [partial(sr.Controller.fail, joint=joint) for joint in locked]}
            record = follow(ctl, PANDA_START, circle(each.arm.forward(PANDA_START)), 400, period, events=events)
            off, turned = 1e3 * record.off[50:], np.degrees(record.turned[50:])
            size = np.max(np.abs(record.rates), axis=1)[100:]
            cells = (f"{np.mean(v):.2f} / {np.max(v):.2f}" for v in (off, turned, size))
            joints = " and ".join(f"j{joint + 1}" for joint in sorted(locked))
            rows.append((joints, name, *cells, f"{record.variation:.1f}"))
            if "position" in name:
                text = f"{name}, {joints} locked: {np.max(off):.2f} mm off after the first second, at most 2"
                claims.append(Claim(text, float(np.max(off)) <= 2.0))
    head = ("locked", "price", "position off mm: mean / worst", "attitude off deg", "largest rate rad/s", "variation")
    return table(head, rows), claims


def stretched(n: int = 30, short: float = 0.7, seconds: float = 20.0) -> Part:
    """A snake whose target is out of reach."""
    arm, period, rows, changes, limit = sr.arms.snake(n), 0.01, [], {}, np.full(n, RATE)
    end = arm.forward(np.zeros(n))
    end[:3, 3] *= 1.0 + short / np.linalg.norm(end[:3, 3])
    path = Path(end, np.zeros(3), np.zeros(3), np.zeros(6), np.zeros(6))
    q = np.random.default_rng(2).uniform(-0.3, 0.3, n)
    for name, law in {"80, the default": sr.LeastError(), "None, the bare optimum": BARE}.items():
        ctl = sr.Controller(arm, law=law, period=period, velocity_limits=RATE)
        record = follow(ctl, q, path, round(seconds / period), period)
        near = np.flatnonzero(record.off <= short + 0.01)
        first = f"{period * near[0]:.2f}" if near.size else "never"
        after = replace(record, rates=record.rates[round(STARTED / period) :])
        changes[name] = (record.sign_changes(0.5 * limit), after.sign_changes(1e-6 * limit))
        cells = (record.sign_changes(0.0 * limit), *changes[name])
        rows.append((name, f"{1e3 * (record.off[-1] - short):.3f}", first, *cells))
    head = ("price", "further off than it must be at the end mm", "within 10 mm of that after s", "sign changes")
    text = table((*head, "above half of a limit", f"after {STARTED:g} s, above 1e-6 of a limit"), rows)
    half, late = changes["80, the default"]
    claim = f"snake({n}), {short} m short, 10 ms: {half} sign changes above half of a limit, {late} after {STARTED:g} s"
    return text, [Claim(claim, half == late == 0)]


def paper_example() -> Part:
    """Example 2 of the paper, joints 2, 4 and 7 failed, with feedback and null motion on manipulability."""
    scenario = examples.scenarios()[examples.EXAMPLE_2_STILLREACH]
    rows = []
    for name, law in {"80, the default": sr.LeastError(), "None, the bare optimum": BARE}.items():
        run = sr.simulate(replace(scenario, law=law), progress=False)
        off, turned = (values[-1] for values in measure.off_target(run))
        moved = np.linalg.norm(measure.displacement(run))
        rows.append((name, f"{moved:.3f}", f"{off:.4f}", f"{turned:.4f}", f"{np.max(np.abs(run.rates)) / RATE:.3f}"))
        if len(rows) == 1:
            held = off <= 0.016 and turned <= 0.01
            claim = Claim(f"{moved:.2f} of 100 in, {off:.4f} in and {turned:.4f} deg off: at most 0.016, 0.01", held)
    head = ("price", "moved in, of 100", "off in", "off deg", "largest rate / limit")
    return table(head, rows), [claim]
