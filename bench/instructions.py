"""Instructions of one tick, or row of a batch, counted by valgrind's callgrind: the same on every run.

``make instructions`` prints them beside the stored figures and stores the new ones in ``instructions.toml``;
``tests/unit/test_instruction_counts.py`` keeps them within 5 %.
"""

import argparse
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

STORED = Path(__file__).with_name("instructions.toml")
TOLERANCE = 0.05
SET = {**os.environ, "STILLREACH_INSTRUCTIONS": "avx2"}
"""Valgrind knows no AVX-512."""
TICKS = 1000
CALLGRIND = [
    "valgrind",
    "--tool=callgrind",
    "--callgrind-out-file=/dev/null",
    "--collect-atstart=no",
    "--toggle-collect=piece",
]
HEAD = """\
# Instructions of one tick, or row of a batch, of each kind of bench/ticks.cpp, and what they hold for.
# Written by `make instructions`.
"""


@dataclass(frozen=True)
class Counts:
    """Instructions a tick by kind, and the compiler ("GCC 12.2.0") and instruction set that they hold for."""

    compiler: str
    instruction_set: str
    instructions: dict[str, int]

    @classmethod
    def stored(cls) -> "Counts":
        return cls(**tomllib.loads(STORED.read_text()))

    @classmethod
    def nothing_yet(cls, ticks: Path) -> "Counts":
        """What the driver `ticks` can do, with no counts."""
        lines = subprocess.run([ticks], capture_output=True, text=True, check=True, env=SET).stdout.splitlines()
        return cls(lines[0], lines[1], dict.fromkeys(lines[2:], 0))

    def toml(self) -> str:
        lines = [f'compiler = "{self.compiler}"', f'instruction_set = "{self.instruction_set}"', "", "[instructions]"]
        return HEAD + "\n".join(lines + [f'"{kind}" = {count}' for kind, count in self.instructions.items()]) + "\n"

    def unlike(self, other: "Counts") -> str | None:
        """Why counts of the two cannot be compared; None where they can."""
        ours, theirs = (re.sub(r"\..*", "", counts.compiler) for counts in (self, other))
        if ours != theirs:
            return f"counted for {theirs}, this is {ours}"
        if self.instruction_set != other.instruction_set:
            return f"counted for {other.instruction_set}, this machine runs {self.instruction_set}"
        return None


def count(ticks: Path, kind: str) -> int:
    """Instructions that one tick of the kind takes, on average."""
    done = subprocess.run([*CALLGRIND, ticks, kind, str(TICKS)], capture_output=True, text=True, check=False, env=SET)
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not collected or collected[1] == "0":
        raise RuntimeError(f"callgrind counted nothing for '{kind}':\n{done.stdout}{done.stderr}")
    return round(int(collected[1]) / TICKS)


def out_of_line(measured: int, stored: int) -> bool:
    """More than 5 % off the stored figure, to either side: a better figure is to be stored."""
    return abs(measured - stored) > TOLERANCE * stored


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ticks", type=Path, help="the driver, compiled by CMake from bench/ticks.cpp")
    parser.add_argument("--store", action="store_true", help=f"write the counts to {STORED.name}")
    arguments = parser.parse_args()
    able = Counts.nothing_yet(arguments.ticks)
    before = Counts.stored() if STORED.exists() else able
    note = able.unlike(before)
    print(f"{able.compiler}, {able.instruction_set}" + (f"; stored figures do not compare: {note}" if note else ""))
    measured = {}
    for kind in able.instructions:
        measured[kind] = count(arguments.ticks, kind)
        old = before.instructions.get(kind)
        beside = f"  stored {old:7d}  {measured[kind] / old - 1:+7.1%}" if old else ""
        print(f"{kind:24s}{measured[kind]:8d}{beside}", flush=True)
    if arguments.store:
        STORED.write_text(Counts(able.compiler, able.instruction_set, measured).toml())
    return 0


if __name__ == "__main__":
    sys.exit(main())
