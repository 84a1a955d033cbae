"""What is done with a spoiled file, and what may come of it: an answer that can be used, or a documented error."""

import dataclasses
import random
import time
import warnings
from pathlib import Path

import numpy as np

import stillreach as sr
from stillreach.errors import RobotFileError, ScenarioFileError
from tests.fuzzing import corpus, spoil, toml, urdf

MOST_TICKS = 300
LONGEST_MESSAGE = 20_000


class Watch:
    """Calls functions, and remembers the longest call's processor time in `longest` [s]."""

    def __init__(self):
        self.longest = 0.0

    def __call__(self, call, *args, **settings):
        start = time.process_time()
        try:
            return call(*args, **settings)
        finally:
            self.longest = max(self.longest, time.process_time() - start)


class Broken(AssertionError):
    """A file was taken or refused in a way that helps nobody."""


def _demand(condition, what):
    if not condition:
        raise Broken(what)


def read_robot(path, rng, watch):
    """'accepted' or 'refused'; anything else is an exception."""
    try:
        arm = _chain(path, rng, watch)
    except RobotFileError as error:
        _check_refusal(error, path, error.expected, [error.line])
        return "refused"
    _check_arm(arm, rng, watch)
    return "accepted"


def _chain(path, rng, watch):
    """The arm; where the file has several ends, or the chain without joints, between two of its links."""
    try:
        return watch(sr.Arm.from_urdf, path)
    except RobotFileError as error:
        if error.argument != "tip" or not error.choices:
            raise
        tip, base = rng.choice(error.choices), rng.choice((None, *error.choices))
        return watch(sr.Arm.from_urdf, path, tip=tip, base=base)


def _check_arm(arm, rng, watch):
    """An arm has poses, a Jacobian, a description, and a file that makes the same arm again."""
    numbers = np.random.default_rng(rng.getrandbits(32))
    q = np.clip(numbers.uniform(-3.0, 3.0, arm.n), *arm.position_limits.T)
    pose, J = watch(arm.forward, q), watch(arm.jacobian, q)
    _demand(np.isfinite(pose).all() and np.isfinite(J).all(), "a pose or Jacobian that is not finite")
    _demand(np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9), "a rotation that is none")
    _demand(watch(arm.describe).strip(), "no description")
    again = watch(sr.Arm.from_urdf, watch(arm.to_urdf))
    scale = 1.0 + max(abs(pose[:3, 3]).max(), *(abs(joint.placement[:3, 3]).max() for joint in arm.joints))
    _demand(again.joint_names == arm.joint_names, "other joints after to_urdf")
    _demand(abs(again.forward(q) - pose).max() < 1e-9 * scale * arm.n, "another pose after to_urdf")


def read_scenario(path, rng, watch):
    """'accepted' or 'refused'; anything else is an exception."""
    del rng
    try:
        scenario = watch(sr.Scenario.load, path)
    except ScenarioFileError as error:
        _demand(error.mistakes, "a refusal without a mistake")
        for mistake in error.mistakes:
            _demand(mistake.got, f"a mistake that does not say what came: {mistake!r}")
        _check_refusal(error, path, "".join(m.expected for m in error.mistakes), [m.line for m in error.mistakes])
        return "refused"
    if scenario.duration / scenario.period <= MOST_TICKS:
        run = watch(sr.simulate, scenario)
        _demand(np.isfinite(run.q).all() and np.isfinite(run.rates).all(), "joint values that are not finite")
    return "accepted"


def _check_refusal(error, path, expected, lines):
    """A refusal names the file, says what was expected, and points at lines that are there."""
    last = Path(path).read_bytes().count(b"\n") + Path(path).read_bytes().count(b"\r") + 1
    _demand(str(path) in str(error), "a refusal that does not name the file")
    _demand(expected, "a refusal that does not say what was expected")
    _demand(all(line is None or 1 <= line <= last for line in lines), f"lines {lines} of a file with {last}")
    _demand(len(str(error)) <= LONGEST_MESSAGE, f"a message of {len(str(error))} characters")


@dataclasses.dataclass(frozen=True)
class Kind:
    """One kind of file.

    Attributes:
        suffix: of its files.
        files: sound ones, as a function.
        mutated: changes one, knowing its format.
        read: what is done with the result.
    """

    suffix: str
    files: object
    mutated: object
    read: object


KINDS = {
    "urdf": Kind(".urdf", corpus.urdf_files, urdf.mutated, read_robot),
    "scenario": Kind(".toml", corpus.scenario_files, toml.mutated, read_scenario),
}


def made(name, kind, files, seed, index):
    """The spoiled file of a number, the same in every run, and the generator that made it."""
    rng = random.Random(f"{name} {seed} {index}")
    data = rng.choice(files)
    if (how := rng.random()) < 0.7:
        data = kind.mutated(rng, data)
    if how > 0.5:
        data = spoil.spoiled(rng, data, files)
    return data, rng


def outcome(kind, path, rng):
    """What came of a file: 'accepted', 'refused', or what should not have; the exception; the longest call [s]."""
    watch = Watch()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return kind.read(path, rng, watch), None, watch.longest
        except Broken as error:
            return f"broken: {error}"[:100], error, watch.longest
        except Exception as error:
            return f"raised {type(error).__name__}", error, watch.longest
