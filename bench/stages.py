"""Prints where the instructions of a batch go, by the function that each was inlined into (needs valgrind).

Valgrind's callgrind counts them one by one: the same on every run, whatever else the machine does. The batches are
those of bench/ticks.cpp, four rows in each vector instruction.
"""

import os
import re
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

from bench.instructions import SET
from bench.report import markdown
from tests.cpp_build import build_targets

BUILD = Path(__file__).parents[1] / "build" / "cpp-lines"
ROWS = 2048
LAWS = {
    "pseudoinverse": "`Pseudoinverse`",
    "exact": "`SingularityRobust`, exact",
    "least error": "`LeastError()`",
    "keep direction": "`KeepDirection`",
}
"""Of the batches of ticks.cpp, and as the tables call them."""
ALONE = "rows solved alone"
STAGES = {
    "search": r"\b(choose_damping|search_box|solve_box)<|/lane_(box|damping)\.hpp",
    "refinement": r"\brefine<",
    "Gram, factor, solve": r"\bsolve_wide<",
    "sines": r"\bsincos(_lanes)?\(",
    "kinematics": r"\bkinematics\(",
    "limits, report": r"\b(finish_\w+|report|ordinary|right_hand_side|weigh_columns|solve_lanes)(<|\()",
    "rows in and out": "",
}
"""By the names of the functions that an instruction was inlined into; the first one that fits decides."""


def stage(frames: list[str]) -> str:
    """The stage of an instruction from these functions, each "name file:line"."""
    if not any("/lane" in frame or "/batch" in frame for frame in frames):
        return ALONE
    return next(name for name, pattern in STAGES.items() if any(re.search(pattern, frame) for frame in frames))


def executed(program: Path, law: str, rows: int) -> Counter[int]:
    """How often each instruction of the program was executed, by address."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind"
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--dump-instr=yes"]
        command += ["--compress-pos=no", "--compress-strings=no", "--collect-atstart=no", "--toggle-collect=piece"]
        command += [str(program), f"batch, {law}", str(rows)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=SET)
        if done.returncode != 0:
            raise SystemExit(f"callgrind failed (apt-get install valgrind):\n{done.stderr}")
        return addresses(out.read_text(), program.name)


def addresses(text: str, program: str) -> Counter[int]:
    """Executions by address of this program's own instructions, from callgrind's output."""
    found: Counter[int] = Counter()
    ours = skip = False
    for line in text.splitlines():
        if line.startswith("ob="):
            ours = line.endswith(f"/{program}")
        elif line.startswith("calls="):
            skip = True  # the next line holds what the callee cost, which is counted there
        elif line.startswith("0x"):
            if ours and not skip:
                address, _, cost = line.split()[:3]
                found[int(address, 16)] += int(cost)
            skip = False
    return found


def origins(program: Path, wanted: list[int]) -> dict[int, list[str]]:
    """The functions that each address comes from, innermost inlined call first, as "name file:line"."""
    command = ["addr2line", "-a", "-i", "-f", "-C", "-e", str(program)]
    asked = "\n".join(map(hex, wanted))
    text = subprocess.run(command, input=asked, capture_output=True, text=True, check=True).stdout
    found: dict[int, list[str]] = {}
    for block in re.split(r"^0x(?=[0-9a-f]+$)", text, flags=re.MULTILINE)[1:]:
        address, *lines = block.splitlines()
        found[int(address, 16)] = [f"{name} {place}" for name, place in zip(lines[::2], lines[1::2], strict=True)]
    return found


def main() -> None:
    os.environ["CXXFLAGS"] = "-g"  # tells inlined functions apart, and changes no instruction
    program = build_targets("ticks", build=BUILD) / "tests" / "cpp" / "ticks"
    times = {law: executed(program, law, ROWS) for law in LAWS}
    places = origins(program, sorted({address for one in times.values() for address in one}))
    lines = []
    for law, title in LAWS.items():
        counted: Counter[str] = Counter()
        for address, often in times[law].items():
            counted[stage(places[address])] += often
        cells = [f"{counted[name] / ROWS:.0f}" for name in (*STAGES, ALONE)]
        lines.append([title, *cells, f"{counted.total() / ROWS:.0f}"])
    print(markdown(("instructions a row", *STAGES, ALONE, "all"), lines))


if __name__ == "__main__":
    main()
