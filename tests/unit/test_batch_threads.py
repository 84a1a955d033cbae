"""A batch on several threads: the same answers, a free interpreter, forks, Ctrl-C."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import stillreach as sr
from stillreach import _core
from tests.conformance.batches import ANSWERS, mixed_rows

ARM = sr.arms.nasa_modular()
LAW = sr.LeastError()


def ask(rows, threads=None, law=LAW, **kwargs):
    return sr.solve_batch(ARM, law, rows.q, rows.twist, rows.bounds, threads=threads, **kwargs)


def same(one, other):
    for name in ("rates", "status", *ANSWERS):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True), name
    return True


@pytest.mark.parametrize(
    "law",
    [
        sr.Pseudoinverse(),
        sr.SingularityRobust(damping="exact"),
        sr.SingularityRobust(damping="closed-form"),
        LAW,
        sr.KeepDirection(),
    ],
    ids=lambda law: type(law).__name__,
)
def test_the_number_of_threads_changes_no_bit(law):
    rows = mixed_rows(ARM, 3000, seed=1)
    one = ask(rows, 1, law, want=ANSWERS)
    for threads in (2, 5, 64, None):
        assert same(one, ask(rows, threads, law, want=ANSWERS))


def test_arms_of_different_sizes_in_turn():
    """The threads' memory grows and is used again."""
    for n in (6, 60, 3, 20, 60, 6):
        arm = sr.arms.snake(n)
        rows = mixed_rows(arm, 600, seed=n)
        law = sr.LeastError(weights=sr.Weights(joints=np.diag(np.linspace(1, 2, n)))) if n == 20 else LAW
        one, other = (sr.solve_batch(arm, law, rows.q, rows.twist, rows.bounds, threads=t) for t in (1, 3))
        assert np.array_equal(one.rates, other.rates)


def test_the_environment_says_how_many(monkeypatch):
    for text, expected in (("3", 3), ("1", 1), ("5000", 1024)):
        monkeypatch.setenv("STILLREACH_THREADS", text)
        assert _core.default_threads() == expected
    monkeypatch.delenv("STILLREACH_THREADS")
    here = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    assert _core.default_threads() == here
    for text in ("", "0", "-2", "many"):
        monkeypatch.setenv("STILLREACH_THREADS", text)
        assert _core.default_threads() == here


def run(code, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        env={**os.environ, **environment},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.split()


COUNTED = """
import os
import numpy as np, stillreach as sr
arm = sr.arms.nasa_modular()
def threads():
    return len(os.listdir("/proc/self/task"))
before = threads()
for _ in range(3):
    sr.solve_batch(arm, sr.LeastError(), np.zeros((4000, 11)), np.ones(6), sr.Bounds.symmetric(1.0, n=11))
    print(threads() - before)
sr.solve_batch(arm, sr.LeastError(), np.zeros((4000, 11)), np.ones(6), sr.Bounds.symmetric(1.0, n=11), threads=6)
print(threads() - before)
sr.solve_batch(arm, sr.LeastError(), np.zeros((600, 11)), np.ones(6), sr.Bounds.symmetric(1.0, n=11), threads=50)
print(threads() - before)
"""


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads are counted in /proc")  # noqa: PTH112
def test_threads_are_started_once_and_no_more_than_there_is_work_for():
    assert run(COUNTED, STILLREACH_THREADS="4") == ["3", "3", "3", "5", "5"]
    assert run(COUNTED, STILLREACH_THREADS="1") == ["0", "0", "0", "5", "5"]


FORKED = """
import os, sys, warnings
import numpy as np, stillreach as sr
warnings.simplefilter("ignore")
arm, rng = sr.arms.nasa_modular(), np.random.default_rng(0)
q, twist = rng.normal(size=(3000, 11)), rng.normal(size=(3000, 6))
ask = lambda: sr.solve_batch(arm, sr.LeastError(), q, twist, sr.Bounds.symmetric(0.5, n=11), threads=4).rates
expected = ask()
for generation in range(3):
    child = os.fork()
    if child:
        _, status = os.waitpid(child, 0)
        assert np.array_equal(ask(), expected)
        sys.exit(os.waitstatus_to_exitcode(status))
    assert np.array_equal(ask(), expected)
    assert len(os.listdir("/proc/self/task")) == 4, os.listdir("/proc/self/task")
"""


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads are counted in /proc")  # noqa: PTH112
def test_a_child_of_a_fork_has_threads_of_its_own():
    """Child, grandchild and great-grandchild run batches on four threads, and so does the parent afterwards."""
    run(FORKED)


def test_a_fork_while_another_thread_runs_a_batch():
    code = FORKED.split("expected = ask()")[0] + (
        "import threading\n"
        "expected, stop = ask(), threading.Event()\n"
        "def work():\n"
        "    while not stop.is_set(): ask()\n"
        "thread = threading.Thread(target=work); thread.start()\n"
        "for _ in range(20):\n"
        "    child = os.fork()\n"
        "    if child == 0:\n"
        "        os._exit(0 if np.array_equal(ask(), expected) else 1)\n"
        "    assert os.waitpid(child, 0)[1] == 0\n"
        "stop.set(); thread.join()\n"
    )
    run(code)


def test_several_python_threads_at_once():
    questions = [mixed_rows(ARM, 1500 + 100 * k, seed=20 + k) for k in range(4)]
    expected = [ask(rows, 1).rates for rows in questions]
    wrong = []

    def work(k):
        for _ in range(6):
            if not np.array_equal(ask(questions[k], threads=1 + k % 3).rates, expected[k], equal_nan=True):
                wrong.append(k)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def slow(count):
    """Rows that take some tenths of a millisecond each: sixty coupled joints, in bad places."""
    arm = sr.arms.snake(60)
    coupled = np.eye(60) + 0.3 * np.eye(60, k=1) + 0.3 * np.eye(60, k=-1)
    law = sr.KeepDirection(weights=sr.Weights(joints=coupled))
    rows = mixed_rows(arm, 300, seed=30)[np.arange(count) % 300]

    def ask_slow(threads, out=None):
        return sr.solve_batch(arm, law, rows.q, rows.twist, rows.bounds, threads=threads, out=out).rates

    return ask_slow


def test_the_interpreter_is_free_meanwhile():
    ask_slow = slow(1500)
    ticks, done = [], threading.Event()

    def count():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.perf_counter()
    ask_slow(1)
    ended = time.perf_counter()
    done.set()
    thread.join()
    during = [tick for tick in ticks if began < tick < ended]
    assert len(during) > 3, f"{len(during)} steps of another thread in {ended - began:.3f} s"


@pytest.mark.parametrize("threads", [1, 3])
def test_ctrl_c_ends_a_long_batch(threads):
    many, few = slow(40_000), slow(300)
    out = np.full((40_000, 60), 7.0)
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        many(threads, out)
    timer.join()
    untouched = np.count_nonzero(np.all(out == 7.0, axis=1))
    assert 10_000 < untouched < 40_000
    assert np.array_equal(few(threads), few(1))
