"""Readers with a defect, to see that a campaign finds it."""

import os
import random
import signal
import time
import warnings

from tests.fuzzing.targets import Kind


def files():
    return [b"one", b"two", b"three"]


def changed(rng, data):
    return data + rng.randbytes(4)


def sound(path, rng):
    return rng.choice(("accepted", "refused"))


def raises(path, rng):
    raise KeyError(path.name)


def warns(path, rng):
    warnings.warn("not meant for users", RuntimeWarning, stacklevel=1)
    return "accepted"


def takes_long(path, rng):
    end = time.process_time() + 1.1
    while time.process_time() < end:
        pass
    return "accepted"


def takes_memory(path, rng):
    return "accepted" if bytearray(3 * 2**30) else "refused"


def errs(path, rng):
    """Now one, now another of what can be told from outside without losing the process."""
    return rng.choice((raises, raises, warns, warns, takes_memory, takes_memory, takes_long))(path, rng)


def crashes(path, rng):
    os.kill(os.getpid(), signal.SIGSEGV)


def hangs(path, rng):
    time.sleep(1000.0)


def kind(defect, often=1.0):
    """Files of which some meet a defect."""
    return Kind(".bin", files, changed, Sometimes(defect, often))


class Sometimes:
    """Reads most files as it should."""

    def __init__(self, defect, often):
        self.defect, self.often = defect, often

    def __call__(self, path, rng, watch):
        chance = random.Random(path.read_bytes()).random()
        return watch(self.defect if chance < self.often else sound, path, rng)
