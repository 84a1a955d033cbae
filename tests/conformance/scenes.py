"""Every fault and limit at several poses of an arm, and a list of what did not hold where."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

import stillreach as sr
from oracles.price import ENDLESS
from tests.conformance.registry import FAULTS, LIMITS, SUBJECTS


@dataclass(frozen=True)
class Scene:
    """One question to a law; rates, bounds and twist as the law takes them.

    Attributes:
        j, twist: Jacobian (m, n) and twist (m,); `rows`, `joints` their kinds in letters.
        lower, upper: (n,) bounds.
        limits: (n,) of the joints' rates, where they are told to the law: an infinite bound counts as a constant, which
            does not change with the units. None: as the bounds say.
        label: arm, pose, fault, limit, twist.
        length: typical of the arm, in the units of the rows.
    """

    j: np.ndarray
    twist: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    rows: str
    joints: str
    label: str
    limits: np.ndarray | None = None
    length: float = 1.0

    @property
    def fixed(self) -> np.ndarray:
        """(n,) joints with one rate left."""
        return self.lower == self.upper

    @cached_property
    def bounds(self) -> sr.Bounds:
        """Lower and upper bounds."""
        return sr.Bounds(self.lower, self.upper)

    @property
    def counted_limits(self) -> np.ndarray:
        """(n,) what the bounds say of the joints' rate limits: 0 for fixed joints, ENDLESS for infinite ones."""
        most = np.maximum(np.abs(self.lower), np.abs(self.upper))
        return np.where(self.fixed, 0.0, np.where(np.isfinite(most), most, ENDLESS))

    @cached_property
    def ratios(self) -> np.ndarray:
        """Singular values of the working joints' Jacobian over the largest, falling."""
        j = self.j[:, ~self.fixed]
        sigma = np.linalg.svd(j, compute_uv=False) if j.size else np.zeros(1)
        return sigma / (sigma[0] or 1.0)

    def ask(self, law, **kwargs):
        """The law's answer."""
        kwargs = {"row_kinds": self.rows, "joint_kinds": self.joints, "velocity_limits": self.limits} | kwargs
        kwargs["length"] = self.length
        return law.solve(self.j, self.twist, self.bounds, **kwargs)

    def without_limits(self):
        """The same with bounds on fixed joints only."""
        lower, upper = (np.where(self.fixed, self.lower, side) for side in (-np.inf, np.inf))
        return replace(self, lower=lower, upper=upper)

    def times(self, s):
        """Twist and all bounds times s."""
        scaled = {"twist": s * self.twist, "lower": s * self.lower, "upper": s * self.upper}
        return replace(self, **scaled, limits=s * self.counted_limits)

    def size(self, rates):
        """What differences of rates are measured by: the largest rate, and 1e-9 of what bounds and twist suggest."""
        finite = [np.max(np.abs(side[np.isfinite(side)]), initial=0.0) for side in (self.lower, self.upper)]
        asked = np.linalg.norm(self.twist) / (np.linalg.norm(self.j) or 1.0)
        return max(np.max(np.abs(rates)), 1e-9 * max(*finite, asked))

    def has_clear_rank(self, low=1e-12, high=1e-6):
        """No singular value is so small, relative to the largest, that rounding decides what becomes of it."""
        return not np.any((self.ratios > low) & (self.ratios < high))

    def has_distinct_singular_values(self):
        """No two are equal, the zeros apart."""
        kept = self.ratios[self.ratios > 1e-12]
        return np.all(kept[:-1] - kept[1:] > 1e-9)


@cache
def scenes(arm_name) -> tuple[Scene, ...]:
    """The arm under every fault and limit (or a sample of them), at a random pose and at a special one each."""
    return tuple(_scenes(arm_name))


def _scenes(arm_name) -> Iterator[Scene]:
    subject = SUBJECTS[arm_name]
    arm, rows = subject.make(), list(subject.rows)
    joints = "".join("RP"[kind] for kind in arm.kinds)
    signs = np.where(np.arange(arm.n) % 2 == 0, 1.0, -1.0)
    special = {"straight": np.zeros(arm.n), "nearly straight": 1e-3 * signs, "1e-8 off straight": 1e-8 * signs}
    shift = list(SUBJECTS).index(arm_name)
    for f, (fault, break_) in enumerate(FAULTS.items()):
        for k, (limit, bound) in enumerate(LIMITS.items()):
            if (k - f + shift) % subject.sample:
                continue
            rng = np.random.default_rng([zlib.crc32(arm_name.encode()), f, k])
            name = list(special)[(f + k) % len(special)]
            for pose, q in (("random", rng.uniform(-2.5, 2.5, arm.n)), (name, special[name])):
                lower, upper = break_(rng, *bound(rng, arm.n))
                j = arm.jacobian(q)[rows]
                wanted, twist = _twist(rng, j, lower, upper)
                label = f"{arm_name}, {pose} pose, fault {fault}, limits {limit}, {wanted} twist"
                yield Scene(j, twist, lower, upper, "".join("vvvwww"[r] for r in rows), joints, label)


def _twist(rng, j, lower, upper):
    """One that the bounds allow, one that is too much, or none."""
    wanted = rng.choice(["reachable", "large", "zero"], p=[0.5, 0.4, 0.1])
    if wanted == "reachable":
        low, high = (np.clip(side, -1.0, 1.0) for side in (lower, upper))
        return wanted, j @ (low + rng.uniform(0.2, 0.8, len(low)) * (high - low))
    return wanted, 3.0 * rng.normal(size=len(j)) * (wanted == "large")


class Broken(list):
    """Notes which facts did not hold where."""

    def unless(self, fact, scene, *numbers):
        """Notes the scene if the fact does not hold; `numbers` are shown."""
        if not fact:
            self.append(f"{scene.label}: {' '.join(f'{n:.6g}' for n in numbers)}")

    def settle(self, count):
        """Fail if any fact did not hold, or if nothing was asked."""
        assert count > 0
        assert not self, f"{len(self)} of {count}:\n" + "\n".join(self[:15])
