"""Single ticks: the README's, random poses near and far from the limits, and what gives way at which prices."""

import numpy as np

import stillreach as sr
from bench.judge import judge
from bench.problem import make_problem
from bench.tracking.setting import BARE, ELBOW, LAWS, Claim, Machine, Part, percent, table, twists
from bench.workload import LIMIT, arm
from stillreach import _core

EXACT = 1e-4
"""Of the largest singular value: a smaller one may be rounding in the robot file."""
FAR = 1e6
"""[rad/s] A limit that no joint meets."""
SPEEDS = (0.01, 0.1)
"""[m/s]"""
PRICES: dict[str, sr.Law] = {
    "80": sr.LeastError(),
    "(100, 80)": sr.LeastError(price=(100.0, 80.0)),
    "(100, 8)": sr.LeastError(price=(100.0, 8.0)),
    '"position-first"': sr.LeastError(price="position-first"),
    "(100, 2)": sr.LeastError(price=(100.0, 2.0)),
    "(500, 40)": sr.LeastError(price=(500.0, 40.0)),
}


def readme_ticks(count: int = 1024) -> Part:
    """The README's ticks, half of them feasible."""
    problem = make_problem(count)
    bounds = sr.Bounds.symmetric(LIMIT, n=arm().n).lock([int(joint) for joint in problem.locked])
    rows, missed = [], {}
    for name, law in {**LAWS, "None, the bare optimum": BARE}.items():
        answers = sr.solve_batch(arm(), law, problem.q, problem.twist, bounds)
        verdict = judge(problem, answers.rates)
        missed[name] = verdict.missed
        errors = np.einsum("tij,tj->ti", problem.jacobian, answers.rates) - problem.twist
        share = (np.linalg.norm(errors, axis=1) / np.linalg.norm(problem.twist, axis=1))[problem.feasible]
        excess = (f"{100.0 * verdict.excess:.3f}", f"{100.0 * verdict.worst_excess:.2f}")
        rows.append((name, f"{verdict.missed} of {verdict.feasible}", f"{100.0 * np.max(share):.2g}", *excess))
    head = ("price", "feasible missed", "worst of them, % of the twist", "excess error of infeasible ticks: mean %")
    text = table((*head, "worst %"), rows)
    return text, [Claim("the default misses no feasible tick of README", missed["80, the default"] == 0)]


def random_poses(machines: list[Machine], count: int = 6000) -> Part:
    """Every pose asked for one random twist; all limits far away, then the arm's own, which forbid some of them."""
    rows, claims = [], []
    for each in machines:
        for locked in (None, ELBOW):
            for speed in SPEEDS:
                far, own = (missing(each, count, speed, locked, far) for far in (True, False))
                name = each.name if locked is None else f"{each.name}, j{locked + 1} locked"
                rows.append((name, speed, possible(each, count, locked), *shares(far), *shares(own)))
                if locked is None and speed == SPEEDS[0] and each.name in ("Panda", "iiwa 14"):
                    share = np.mean(far > 0.01)
                    claims.append(
                        Claim(f"{name} at 1 cm/s: {100 * share:.2f} % miss over 1 %, at most 4", share <= 0.04)
                    )
    head = ["arm", "m/s", "σ6 > 1e-4 σ1, % of poses"]
    for limits in ("limits far", "its own"):
        head += [f"{limits}: miss > 1 %, % of poses", "> 10 %", "mean error %", "worst %"]
    return table(head, rows), claims


def shares(errors: np.ndarray) -> tuple[str, ...]:
    """Relative errors as a row's cells."""
    return percent(errors > 0.01), percent(errors > 0.1), percent(errors), percent(np.max(errors), 0)


def possible(each: Machine, count: int, locked: int | None) -> str:
    """In how many poses the arm can do any twist at all, slowly: an iiwa's elbow cannot be spared."""
    working = np.arange(each.arm.n) != (-1 if locked is None else locked)
    sigma = np.linalg.svd(each.arm.jacobian(each.poses(count, 10))[:, :, working], compute_uv=False)
    return percent(sigma[:, -1] > EXACT * sigma[:, 0], 1)


def missing(each: Machine, count: int, speed: float, locked: int | None, far: bool) -> np.ndarray:
    """(count,) the error of the default law relative to the twist; b is that of the arm, also with limits far away."""
    limits, law = each.limits.copy(), sr.LeastError().core()
    if locked is not None:
        limits[locked] = 0.0
    typical = _core.typical_rate(each.metric, limits)
    bound = np.where(limits > 0.0, FAR, 0.0) if far else limits
    asked = twists(count, speed, 11)
    errors = [
        _core.solve(law, each.metric, J, x, -bound, bound, None, None, typical).task_error / np.linalg.norm(x)
        for J, x in zip(each.arm.jacobian(each.poses(count, 10)), asked, strict=True)
    ]
    return np.array(errors)


def giving_way(machines: list[Machine], count: int = 3000) -> Part:
    """Poses whose pseudoinverse is inside the limits: in how many does something give way all the same?"""
    rows = []
    for each in machines:
        q, bounds = each.poses(count, 12), (-each.limits, each.limits)
        for speed in SPEEDS:
            x = twists(count, speed, 13)
            free = sr.solve_batch(each.arm, sr.Pseudoinverse(), q, x, bounds, want="task_error")
            size = np.linalg.norm(x, axis=1)
            inside = np.all(np.abs(free.rates) <= each.limits, axis=1) & (free.task_error <= 1e-9 * size)
            cells = []
            for law in PRICES.values():
                errors = sr.solve_batch(each.arm, law, q[inside], x[inside], bounds, want="task_error").task_error
                share = errors / size[inside]
                cells.append(f"{percent(share > 1e-6, 1)} / {percent(np.max(share, initial=0.0), 0)}")
            rows.append((each.name, speed, int(np.sum(inside)), *cells))
    head = ("arm", "m/s", f"inside, of {count}", *(f"{name}: % of poses / worst error %" for name in PRICES))
    return table(head, rows), []
