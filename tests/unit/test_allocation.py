"""A bound tick takes nothing from the heap: malloc counted in a process of its own, Python's objects included.

PYTHONMALLOC=malloc sends every Python object to malloc, and a small library, preloaded, counts the calls. The only
ticks that may allocate are those that return a status which that process has not seen before: it becomes a Status
member once.
"""

import json
import os
import shutil
import subprocess
import sys

import pytest

COUNTER = """
#include <cstddef>
extern "C" {
void* __libc_malloc(std::size_t); void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t); void* __libc_memalign(std::size_t, std::size_t);
volatile long heap_calls = 0;
void* malloc(std::size_t size) { heap_calls = heap_calls + 1; return __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) { heap_calls = heap_calls + 1; return __libc_calloc(count, size); }
void* realloc(void* old, std::size_t size) { heap_calls = heap_calls + 1; return __libc_realloc(old, size); }
void* memalign(std::size_t a, std::size_t size) { heap_calls = heap_calls + 1; return __libc_memalign(a, size); }
void* aligned_alloc(std::size_t a, std::size_t size) { heap_calls = heap_calls + 1; return __libc_memalign(a, size); }
int posix_memalign(void** out, std::size_t a, std::size_t size) { return (*out = memalign(a, size)) ? 0 : 12; }
}
"""

COUNTED = """
import ctypes, gc, json, sys
import numpy as np
import stillreach as sr

counter = ctypes.c_long.in_dll(ctypes.CDLL(sys.argv[1]), "heap_calls")
gc.disable()
LAWS = {
    "Pseudoinverse": sr.Pseudoinverse(),
    "SingularityRobust, exact": sr.SingularityRobust(damping="exact"),
    "SingularityRobust, closed form": sr.SingularityRobust(damping="closed-form"),
    "SingularityRobust, number": sr.SingularityRobust(damping=1e-3),
    "LeastError": sr.LeastError(),
    "LeastError, bare": sr.LeastError(price=None),
    "KeepDirection": sr.KeepDirection(),
}


def taken(call):
    '''Allocations of one call, less those of the counting itself.'''
    before = counter.value
    nothing = counter.value - before
    before = counter.value
    call()
    return counter.value - before - nothing


def life(arm, law, statuses):
    '''Allocations of each tick, and whether it returned a new status, over failures and restores.'''
    random = np.random.default_rng(1)
    ctl = sr.Controller(arm, law=law, position_limits=(-20.0, 20.0))
    q, twist, rates = random.uniform(-1.5, 1.5, arm.n), np.zeros(6), np.zeros(arm.n)
    target = arm.forward(q + 0.01).round(6) if arm.n == 11 else None
    tick = ctl.bind(q=q, twist=twist, rates=rates, target=target, period=np.array([0.013]) if arm.n == 11 else None)
    answer = [None]

    def call():
        answer[0] = tick()

    seen = []
    for t in range(60):
        if t % 10 == 3:
            ctl.fail(int(random.integers(arm.n)))
        if t % 10 == 5:
            ctl.fail(int(random.integers(arm.n)), sr.Runaway(0.05))
        if t % 10 == 8:
            for joint in list(ctl.faults):
                ctl.restore(joint)
            ctl.set_limits(velocity=1.0 / (1 + t), acceleration=5.0)
        twist[:] = random.normal(size=6) * (0.01, 0.3, 10.0)[t % 3]
        q[0] = np.nan if t % 20 == 19 else 0.3
        count = taken(call)
        seen.append((count, answer[0] not in statuses))
        statuses.add(answer[0])
    return seen


def main():
    planted = {
        "nothing": taken(lambda: None),
        "bytes": taken(lambda: bytes(100)),
        "array": taken(lambda: np.empty(11)),
        "step": taken(lambda: sr.Controller(sr.arms.planar(3)).step(np.ones(3), np.ones(6))),
    }
    lives, statuses = {}, set()
    for name, law in LAWS.items():
        for arm in (sr.arms.planar(3), sr.arms.nasa_modular(), sr.arms.snake(500)):
            first = life(arm, law, statuses)
            lives[f"{name}, {arm.n} joints"] = first + life(arm, law, statuses)
    print(json.dumps({"planted": planted, "lives": lives}))


main()
"""


@pytest.fixture(scope="module")
def counted(tmp_path_factory):
    """What the counted process reports."""
    compiler = shutil.which("c++") or shutil.which("g++")
    if not (sys.platform == "linux" and os.confstr("CS_GNU_LIBC_VERSION")):
        pytest.skip("malloc is counted through the GNU C library")
    assert compiler, "a C++ compiler built this package"
    folder = tmp_path_factory.mktemp("heap")
    source, library, script = folder / "heap.cpp", folder / "heap.so", folder / "counted.py"
    source.write_text(COUNTER)
    script.write_text(COUNTED)
    subprocess.run([compiler, "-O1", "-shared", "-fPIC", source, "-o", library], check=True)
    environment = {**os.environ, "LD_PRELOAD": str(library), "PYTHONMALLOC": "malloc"}
    command = [sys.executable, script, library]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_planted_allocations_are_seen(counted):
    planted = counted["planted"]
    assert planted["nothing"] == 0
    assert min(planted["bytes"], planted["array"], planted["step"]) > 0


def test_ticks_take_nothing_from_the_heap(counted):
    """From the first tick on, every law, 3 to 500 joints, across failures, restores and a broken encoder."""
    for name, ticks in counted["lives"].items():
        allocating = [t for t, (count, new_status) in enumerate(ticks) if count and not new_status]
        assert not allocating, f"{name}: ticks {allocating} of {len(ticks)} allocate"


def test_statuses_are_made_once(counted):
    """The rule above excuses few ticks: those with a status for the first time."""
    lives = counted["lives"].values()
    assert sum(new_status for ticks in lives for _, new_status in ticks) <= 30
    for ticks in lives:
        assert not any(new_status for _, new_status in ticks[len(ticks) // 2 :])
