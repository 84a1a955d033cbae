"""Many spoiled files in a process that may crash or hang without taking the count with it."""

import contextlib
import faulthandler
import multiprocessing
import os
import random
import resource
import signal
import tempfile
import time
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzzing import corpus
from tests.fuzzing.targets import KINDS, Kind, made, outcome

SLOW = 1.0
"""[s] of processor time that a call about a file may take."""
SILENCE = 60.0
"""[s] without a report after which a process is ended."""
GRACE = 5.0
"""[s] that it has then to report: a machine that was asleep wakes up with the silence over."""
MEMORY = 2 * 2**30
"""[bytes] that reading may take on top of what is there at the start."""
REPORTED = 1.0
"""[s] between two reports."""
SOUND = ("accepted", "refused")


@dataclass
class Tally:
    """What came of the files so far.

    Attributes:
        files: how many were read.
        outcomes: how many times each outcome came.
        failures: (index, outcome) of the files that should have been read or refused in another way.
        slowest: [s] of processor time of the longest call, and which file it was about.
    """

    files: int = 0
    outcomes: Counter = field(default_factory=Counter)
    failures: list = field(default_factory=list)
    slowest: tuple = (0.0, 0)

    def add(self, index, what, seconds=0.0):
        """One more file; returns what it counts as."""
        if what in SOUND and seconds > SLOW:
            what = f"slow: over {SLOW:g} s"
        self.files += 1
        self.outcomes[what] += 1
        self.slowest = max(self.slowest, (seconds, index))
        if what not in SOUND:
            self.failures.append((index, what))
        return what

    def join(self, other):
        """What another part of the campaign found."""
        self.files += other.files
        self.outcomes += other.outcomes
        self.failures += other.failures
        self.slowest = max(self.slowest, other.slowest)


@dataclass(frozen=True)
class Job:
    """What is spoiled how, and where files that fail are kept.

    Attributes:
        name: "urdf" or "scenario".
        kind: what that means.
        seed: what, with the number of a file, decides how it is spoiled.
        save: a folder, or None.
    """

    name: str
    kind: Kind
    seed: int
    save: Path | None = None

    def file(self, index, sound):
        """The spoiled file of a number, and the generator that made it."""
        return made(self.name, self.kind, sound, self.seed, index)

    def keep(self, index, what, data, trace=""):
        """Puts a file that failed where it can be looked at, and where in the code that was."""
        if self.save is None:
            return
        Path(self.save).mkdir(parents=True, exist_ok=True)
        path = Path(self.save) / f"{self.name}-{self.seed}-{index}{self.kind.suffix}"
        path.write_bytes(data)
        path.with_suffix(".txt").write_text(f"{what}\n{trace}", encoding="utf-8", errors="backslashreplace")


def campaign(job, files, progress=lambda tally: None, silence=SILENCE):
    """The tally of files 0 to `files` - 1; `progress` is called with what there is of it now and then."""
    with tempfile.TemporaryDirectory() as folder:
        return _campaign(job, files, progress, silence, Path(folder) / "stacks")


def _campaign(job, files, progress, silence, stacks):
    tally, start, skip = Tally(), 0, set()
    spawn = multiprocessing.get_context("spawn")
    while start < files:
        mine, theirs = spawn.Pipe(duplex=False)
        current = spawn.Value("q", start)
        worker = spawn.Process(target=work, args=(job, range(start, files), skip, current, theirs, stacks))
        worker.start()
        theirs.close()
        for done, part in reports(mine, SILENCE, silence):
            start = done
            tally.join(part)
            progress(tally)
        worker.join(1.0)
        hung = worker.is_alive()
        stood = where_it_stands(worker, stacks) if hung else ""
        worker.kill()
        worker.join()
        if start < files:
            skip.add(index := current.value)
            what = "hang" if hung else f"crash: exit code {worker.exitcode}"
            job.keep(index, what, job.file(index, job.kind.files())[0], stood)
            tally.add(index, what)
    return tally


def reports(pipe, first, later):
    """What a worker reports, until it ends, crashes or is silent for too long [s]: the first time, and later."""
    silence = first
    with contextlib.suppress(EOFError):
        while pipe.poll(silence) or pipe.poll(GRACE):
            yield pipe.recv()
            silence = later


def where_it_stands(worker, stacks):
    """What a worker that hangs is doing: its processor time, and the lines of Python that it is in."""
    times = os.sysconf("SC_CLK_TCK")
    fields = Path(f"/proc/{worker.pid}/stat").read_text().rpartition(")")[2].split()
    os.kill(worker.pid, signal.SIGUSR1)
    time.sleep(0.5)
    return f"{(int(fields[11]) + int(fields[12])) / times:.1f} s of processor time\n{stacks.read_text()}"


def work(job, indices, skip, current, pipe, stacks):
    """Reads the files, in a process of its own; SIGUSR1 makes it write into the file `stacks` where it stands."""
    faulthandler.register(signal.SIGUSR1, stacks.open("w"), all_threads=True)
    sound, tally, reported = job.kind.files(), Tally(), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        corpus.set_out(folder)
        path = Path(folder) / f"fuzz{job.kind.suffix}"
        warm_up(job, path)
        limit_memory()
        pipe.send((indices.start, tally))  # ready: from now on, silence means something
        for index in (index for index in indices if index not in skip):
            current.value = index
            data, rng = job.file(index, sound)
            path.write_bytes(data)
            what, error, seconds = outcome(job.kind, path, rng)
            what = tally.add(index, what, seconds)
            if what not in SOUND:
                job.keep(index, what, data, "".join(traceback.format_exception(error)) if error else "")
            if time.monotonic() - reported > REPORTED:
                pipe.send((index + 1, tally))
                tally, reported = Tally(), time.monotonic()
        pipe.send((indices.stop, tally))
    pipe.close()


def warm_up(job, path):
    """Reads sound files, so that what is imported on first use counts for no spoiled one."""
    if job.name in KINDS:
        for data in job.kind.files():
            path.write_bytes(data)
            outcome(job.kind, path, random.Random(0))


def limit_memory():
    """An allocation beyond what any file should need fails in this process."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
