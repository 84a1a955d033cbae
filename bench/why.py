"""Runs the commands whose tables are in docs/why-it-is-fast.md and writes what they print into it.

What is written holds for the machine at hand. `batch` uses AVX2, `wide` the same laws with AVX-512.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from bench.page import put

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "why-it-is-fast.md"
PARTS = {
    "batch": ("bench.batch", "--repeats", "30"),
    "wide": ("bench.batch", "--repeats", "30", "--laws"),
    "stages": ("bench.stages",),
    "tick": ("bench.tick",),
    "long_arms": ("bench.long_arms",),
}
SETS = {"batch": "avx2", "wide": "avx512"}


def measure(part: str) -> str:
    """What a part's command prints."""
    environment = os.environ | ({"STILLREACH_INSTRUCTIONS": SETS[part]} if part in SETS else {})
    command = [sys.executable, "-m", *PARTS[part]]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False, env=environment)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    return done.stdout.strip()


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m bench.why", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"what to measure (default: {', '.join(PARTS)})")
    asked = parser.parse_args()
    if unknown := [part for part in asked.parts if part not in PARTS]:
        parser.error(f"PART: {', '.join(unknown)} not among {', '.join(PARTS)}")
    for part in asked.parts or PARTS:
        print(f"{part} …", file=sys.stderr, flush=True)
        put(PAGE, f"figures: {part}", measure(part))


if __name__ == "__main__":
    main()
