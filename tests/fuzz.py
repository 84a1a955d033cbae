"""Reads robot and scenario files that were spoiled, and counts what came of them.

python tests/fuzz.py [--files 100000] [--seed 1] [--kind urdf|scenario] [--save out/fuzz]
python tests/fuzz.py --kind urdf --seed 1 --only 4711    # one file again: what is in it, what comes of it

Every file must be taken or be refused with RobotFileError or ScenarioFileError, within 1 s of processor time; no
warning, no crash, no other exception. Files that fail are saved, and the exit code is 1.
"""

import argparse
import sys
import tempfile
import time
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.fuzzing import corpus
from tests.fuzzing.campaign import SOUND, Job, campaign
from tests.fuzzing.targets import KINDS, outcome


def show(job, index):
    """One file of a campaign and what comes of it; True if that is sound."""
    data, rng = job.file(index, job.kind.files())
    sys.stdout.buffer.write(data + b"\n\n")
    sys.stdout.flush()
    with tempfile.TemporaryDirectory() as folder:
        corpus.set_out(folder)
        path = Path(folder) / f"fuzz{job.kind.suffix}"
        path.write_bytes(data)
        what, error, _ = outcome(job.kind, path, rng)
    if error is not None:
        traceback.print_exception(error)
    print(what)
    return what in SOUND


def line(name, tally, seconds):
    """A line of counts."""
    counts = ", ".join(f"{what} {count}" for what, count in tally.outcomes.most_common())
    slow = f"slowest {tally.slowest[0]:.3f} s (file {tally.slowest[1]})"
    return f"{name}: {tally.files} files in {seconds:.0f} s: {counts}; {slow}"


def run(job, files):
    """A campaign with a line of progress every 10 s; True if nothing failed."""
    start = shown = time.monotonic()

    def progress(tally):
        nonlocal shown
        if time.monotonic() - shown >= 10.0:
            shown = time.monotonic()
            print(line(job.name, tally, shown - start), flush=True)

    tally = campaign(job, files, progress)
    print(line(job.name, tally, time.monotonic() - start))
    for index, what in tally.failures[:20]:
        print(f"  file {index}: {what}; see {job.save}/{job.name}-{job.seed}-{index}.txt")
    return not tally.failures


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--files", type=int, default=100_000, help="how many of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=KINDS, help="only this one")
    parser.add_argument("--save", default="out/fuzz", help="folder for files that fail")
    parser.add_argument("--only", type=int, metavar="INDEX", help="only this file, which is shown")
    given = parser.parse_args()
    kinds = [given.kind] if given.kind else list(KINDS)
    sound = True
    for name in kinds:
        job = Job(name, KINDS[name], given.seed, given.save)
        sound &= run(job, given.files) if given.only is None else show(job, given.only)
    return int(not sound)


if __name__ == "__main__":
    sys.exit(main())
