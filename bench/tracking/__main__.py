"""Measures how well the default law tracks, prints tables as markdown, and says which requirements are met.

`--quick` takes fewer poses and loops; `--only` names parts.
"""

import argparse
import sys
import time
from collections.abc import Callable

from bench.tracking import limits, loops, poses
from bench.tracking.setting import Claim, Part, machines, panda


def parts(quick: bool) -> dict[str, tuple[str, Callable[[], Part]]]:
    """Word, title and what makes the table."""
    all_arms = machines()
    two = [each for each in all_arms if each.name in ("Panda", "iiwa 14")]
    few = 10 if quick else 1
    arm = panda()
    return {
        "readme": ("README's ticks", lambda: poses.readme_ticks(1024 // (8 if quick else 1))),
        "poses": ("Random poses", lambda: poses.random_poses(all_arms, 6000 // few)),
        "prices": ("Feasible poses in which something gives way", lambda: poses.giving_way(all_arms, 3000 // few)),
        "faults": ("Loops through faults, 20 s", lambda: loops.through_faults(two, 20 // few)),
        "accelerating": ("A circle with acceleration limits (Panda)", lambda: loops.accelerating(arm)),
        "generous": ("One joint with a limit of 1e4 rad/s", lambda: limits.generous(all_arms, 500 // few)),
        "one-joint": ("One working joint", lambda: limits.one_joint(all_arms)),
        "way": ("A circle with locked joints (Panda)", lambda: loops.giving_way(arm)),
        "stretched": ("A snake of 30 joints, its target out of reach", loops.stretched),
        "paper": ("The paper's example 2 in closed loop", loops.paper_example),
    }


def main(given: list[str] | None = None) -> int:
    """Prints everything; 1 where a requirement is not met."""
    names = list(parts(quick=True))
    parser = argparse.ArgumentParser(prog="python -m bench.tracking", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer poses and loops")
    parser.add_argument("--only", metavar="A,B", help=f"only these parts: {', '.join(names)}")
    asked = parser.parse_args(given)
    chosen = asked.only.split(",") if asked.only else names
    if unknown := [name for name in chosen if name not in names]:
        parser.error(f"unknown parts: {', '.join(unknown)}; there are {', '.join(names)}")
    claims: list[Claim] = []
    for name, (title, make) in parts(asked.quick).items():
        if name not in chosen:
            continue
        begin = time.monotonic()
        text, own = make()
        claims += own
        print(f"\n## {title}\n\n{text}\n", *own, f"\n{time.monotonic() - begin:.0f} s", sep="\n", flush=True)
    broken = [claim for claim in claims if not claim.holds]
    print(f"\n{len(claims) - len(broken)} of {len(claims)} requirements are met", *broken, sep="\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
