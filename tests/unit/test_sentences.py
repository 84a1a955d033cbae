"""The sentences that a user reads, in one file: tests/golden/messages.txt.

Other tests look at the argument, the choices and the numbers of an error; its words stand here alone. A change of
words is a change of that file: STILLREACH_GOLDEN=write writes it anew. A new sentence is one line more in ERRORS,
in RUNS or in MISTAKES of tests/unit/cli/test_mistakes.py.
"""

import os
import re
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from stillreach.status import IN_WORDS
from tests.commands import run_command
from tests.unit.cli.conftest import REACH, TOO_FAR
from tests.unit.cli.test_mistakes import MISTAKES

GOLDEN = Path(__file__).parents[1] / "golden" / "messages.txt"

ARM = sr.arms.planar(3)
BOUNDS, J = sr.Bounds.symmetric(1.0, n=3), np.eye(3)
LAW = sr.LeastError()
WAIT = sr.ConstantTwist(np.zeros(6), duration=1.0)


def controller() -> sr.Controller:
    return sr.Controller(ARM, velocity_limits=1.0, period=0.01)


ERRORS = {
    # numbers and arrays
    "a vector of another length": lambda: ARM.forward([1.0, 2.0]),
    "a NaN in a vector": lambda: ARM.forward([0.0, np.nan, 0.0]),
    "text for numbers": lambda: ARM.forward("abc"),
    "a truth value for a number": lambda: ARM.forward([0.0, True, 0.0]),
    "a ragged list": lambda: ARM.forward([[0.0], [0.0, 1.0]]),
    "a masked array": lambda: ARM.forward(np.ma.array([0.0, 1.0, 2.0], mask=[0, 1, 0])),
    "a number that is not above 0": lambda: sr.Controller(ARM, period=0.0),
    "a count that is not an integer": lambda: sr.arms.planar(2.5),
    "a matrix that is not a pose": lambda: ARM.with_tool(np.eye(3)),
    "a rotation that is off": lambda: ARM.with_tool(np.diag([1.0, 1.0, 1.1, 1.0])),
    "a reflection": lambda: ARM.with_tool(np.diag([1.0, 1.0, -1.0, 1.0])),
    # arms
    "a joint that the arm does not have": lambda: ARM.joint_index("j4"),
    "an index that the arm does not have": lambda: ARM.joint_index(3),
    "a kind of joint that does not exist": lambda: sr.Joint(kind="screw"),
    "an axis without a direction": lambda: sr.Joint(axis=[0.0, 0.0, 0.0]),
    "no joints": lambda: sr.Arm([]),
    "two joints of one name": lambda: sr.Arm([sr.Joint(name="a"), sr.Joint(name="a")]),
    "a sequence of other letters": lambda: sr.Arm.from_modules("RXP", [1.0, 1.0, 1.0]),
    "a robot file that does not exist": lambda: sr.Arm.from_urdf("no-such.urdf"),
    "a robot file that is not XML": lambda: sr.Arm.from_urdf("<robot"),
    "a link that does not exist": lambda: sr.Arm.from_urdf(ARM.to_urdf(), tip="tol"),
    # laws
    "a Jacobian with too many rows": lambda: LAW.solve(np.zeros((7, 3)), np.zeros(7), BOUNDS),
    "a twist of another length": lambda: LAW.solve(J, [1.0, 2.0], BOUNDS, row_kinds="vvv"),
    "bounds that are not bounds": lambda: LAW.solve(J, np.zeros(3), (-1.0, 1.0), row_kinds="vvv"),
    "bounds of another arm": lambda: LAW.solve(J, np.zeros(3), sr.Bounds.symmetric(1.0, n=4), row_kinds="vvv"),
    "rows of an unknown kind": lambda: LAW.solve(J, np.zeros(3), BOUNDS, row_kinds="xyz"),
    "a lower bound above the upper one": lambda: sr.Bounds([1.0], [0.0]),
    "a price that is not above 0": lambda: sr.LeastError(price=0.0),
    "a price that is another word": lambda: sr.LeastError(price="position"),
    "a damping that is another word": lambda: sr.SingularityRobust(damping="EXACT"),
    "a norm that does not exist": lambda: sr.SingularityRobust(norm="1"),
    "a rank tolerance of 1": lambda: sr.Pseudoinverse(rank_tolerance=1.0),
    "a weight below 0": lambda: sr.Weights(joints=[-1.0, 1.0]),
    "a weight with a negative eigenvalue": lambda: sr.Weights(task=[[1.0, 2.0], [2.0, 1.0]]),
    "a task without rows": lambda: sr.Task(rows=[False] * 6),
    # controllers
    "a law that is not a law": lambda: sr.Controller(ARM, law="least-error"),
    "a fault that is not a fault": lambda: controller().fail("j1", 3),
    "a fraction above 1": lambda: sr.Derated(1.5),
    "a rate that is not a number": lambda: sr.Runaway(np.inf),
    "a joint to fail that does not exist": lambda: controller().fail("j9"),
    "a twist of another length in a tick": lambda: controller().step([0.0, 0.0, 0.0], [1.0]),
    # batches
    "rows of two lengths": lambda: sr.solve_batch(ARM, LAW, np.zeros((4, 3)), np.zeros((3, 6)), BOUNDS),
    "a thing that a batch does not return": lambda: sr.solve_batch(
        ARM, LAW, np.zeros((4, 3)), np.zeros(6), BOUNDS, want="residuals"
    ),
    "no threads": lambda: sr.solve_batch(ARM, LAW, np.zeros((4, 3)), np.zeros(6), BOUNDS, threads=0),
    # simulations
    "a start of another length": lambda: sr.simulate(sr.Scenario(arm=ARM, start=[0.0], motion=WAIT)),
    "no motion": lambda: sr.Scenario(arm=ARM, start=np.zeros(3), motion=[]),
    "an integrator that does not exist": lambda: sr.Scenario(
        arm=ARM, start=np.zeros(3), motion=WAIT, integrator="eular"
    ),
    "a fault that ends before it begins": lambda: sr.Fault("j1", at=2.0, until=1.0),
    "a scenario that does not exist": lambda: sr.Scenario.load("paper-exampel-2"),
    "a run that does not exist": lambda: sr.Run.load("nothing.nc"),
}
"""Calls that raise an error of this package."""

RUNS = {
    "a run that arrives": ("run", "reach.toml", "--no-plot"),
    "a run that does not arrive": ("run", "too-far.toml", "--no-plot"),
    "rates that no drive follows": (
        "run",
        "reach.toml",
        "--law",
        "pseudoinverse",
        "--fail",
        "j2@1:derated=0.01",
        "--no-plot",
    ),
    "laws compared": ("compare", "reach.toml", "--laws", "least-error,keep-direction", "--no-plot"),
    "an arm looked at": ("inspect", "planar3"),
    "an arm looked at where it is singular": ("inspect", "planar3", "--q", "0,0,0"),
}
"""Arguments of commands whose output is kept, without its numbers: they depend on the processor."""


def raised(call) -> str:
    with pytest.raises((sr.StillreachError, FileNotFoundError)) as caught:
        call()
    return f"{type(caught.value).__name__}: {caught.value}"


def sentences(folder: Path) -> dict[str, str]:
    """What a user reads, by what provokes it."""
    (folder / "reach.toml").write_text(REACH, encoding="utf-8")
    (folder / "too-far.toml").write_text(TOO_FAR, encoding="utf-8")
    said = {name: raised(call) for name, call in ERRORS.items()}
    said |= {f"status {flag}": words for flag, words in IN_WORDS.items()}
    for name, arguments in MISTAKES.items():
        said[f"command: {name}"] = run_command(*arguments, folder=folder).err
    for name, arguments in RUNS.items():
        done = run_command(*arguments, folder=folder)
        said[name] = re.sub(r"[-\d.]*\d(e[-+]\d+)?", "#", done.out + done.err)
    return {name: re.sub(r"[ ─]+\n|[ ─]+$", "\n", re.sub("──+|  +", "  ", text)).strip() for name, text in said.items()}


def written(said: dict[str, str]) -> str:
    return "\n".join(f"== {name}\n{text}\n" for name, text in said.items())


def test_sentences_are_those_of_the_golden_file(tmp_path: Path) -> None:
    text = written(sentences(tmp_path)).replace(str(tmp_path), "FOLDER")
    if os.environ.get("STILLREACH_GOLDEN") == "write":
        GOLDEN.write_text(text, encoding="utf-8")
    assert text.splitlines() == GOLDEN.read_text(encoding="utf-8").splitlines()
