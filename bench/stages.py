"""Where the instructions of a batch go.

Valgrind's callgrind counts them one by one; they are told apart by the function that they come from (inlined ones too)
and by what they do. The same on every run, whatever else the machine does.
"""

import argparse
import json
import re
import subprocess
import tempfile
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

from bench import operations
from bench.batch_tables import table
from bench.kernel import LAWS
from bench.machine import built
from bench.rows import PART_OVER, make_rows

ROWS = 2048
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
ALONE = "rows solved alone"
KINDS = {
    "multiply-add": r"^vfn?m(add|sub)",
    "add, multiply": r"^v?(add|sub|mul)[ps]d",
    "divide, root": r"^v?(div|sqrt)[ps]d",
    "masks, choices": r"^v?(blendv?|cmp\w*|andn?|x?or|max|min|movmsk|u?comi|test)[ps][ds]$"
    r"|^vp(and|x?or|cmp|add|sub|s[lr]l|blend|test)",
    "shuffle": r"^v?(perm|unpck|shuf|insert|extract|broadcast|movddup|movhp|movlp|pinsr|pextr|punpck)",
    "load, store, move": r"^v?mov[adhlnqu]",
}
OTHER = "addresses, loops, branches"


@dataclass(frozen=True)
class Count:
    """Of one law, a row on average: instructions by stage and by kind, and the floating-point operations in them."""

    law: str
    stages: dict[str, float]
    kinds: dict[str, float]
    operations: float

    @property
    def instructions(self) -> float:
        return sum(self.stages.values())


def executed(program: Path, law: str, rows: int, folder: Path) -> Counter[int]:
    """How often each instruction of the program was executed, by address."""
    make_rows(rows).write(folder / "rows")
    out = folder / "callgrind"
    callgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--dump-instr=yes"]
    callgrind += ["--compress-pos=no", "--compress-strings=no", "--collect-atstart=no", "--toggle-collect=piece"]
    done = subprocess.run(
        [*callgrind, program, folder / "rows", str(rows), law], capture_output=True, text=True, check=False
    )
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


def mnemonics(program: Path) -> dict[int, tuple[str, str]]:
    """Name and operands of each instruction, by address."""
    text = subprocess.run(["objdump", "-d", "--no-show-raw-insn", program], capture_output=True, text=True, check=True)
    lines = re.finditer(r"^\s*([0-9a-f]+):\t(\S+)[ \t]*(.*)$", text.stdout, re.MULTILINE)
    return {int(line[1], 16): (line[2], line[3]) for line in lines}


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


def stage(frames: list[str]) -> str:
    """The stage of an instruction from these functions."""
    if not any("/lane" in frame or "/batch" in frame for frame in frames):
        return ALONE
    return next(name for name, pattern in STAGES.items() if any(re.search(pattern, frame) for frame in frames))


def kind(mnemonic: str) -> str:
    """What an instruction does."""
    return next((name for name, pattern in KINDS.items() if re.search(pattern, mnemonic)), OTHER)


def operations_of(mnemonic: str, operands: str) -> int:
    """Floating-point operations of one instruction."""
    what = kind(mnemonic)
    if what not in ("multiply-add", "add, multiply", "divide, root"):
        return 0
    lanes = 1 if mnemonic.endswith("sd") else 4 if "%ymm" in operands else 2
    return lanes * (2 if what == "multiply-add" else 1)


def count_all(program: Path, rows: int) -> list[Count]:
    """Every law. Addresses are looked up once for all of them: that takes longest."""
    with tempfile.TemporaryDirectory() as folder:
        times = {law: executed(program, law, rows, Path(folder)) for law in LAWS}
    names = mnemonics(program)
    places = origins(program, sorted({address for one in times.values() for address in one}))
    return [count(LAWS[law], one, rows, names, places) for law, one in times.items()]


def count(
    law: str, times: Counter[int], rows: int, names: dict[int, tuple[str, str]], places: dict[int, list[str]]
) -> Count:
    """What was executed so many times, by stage and by kind."""
    stages: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    done = 0
    for address, often in times.items():
        stages[stage(places[address])] += often
        kinds[kind(names[address][0])] += often
        done += often * operations_of(*names[address])
    return Count(law, share(stages, rows, [*STAGES, ALONE]), share(kinds, rows, [*KINDS, OTHER]), done / rows)


def share(counted: Counter[str], rows: int, names: list[str]) -> dict[str, float]:
    """A row's part, in this order."""
    return {name: counted[name] / rows for name in names}


def by_stage(counts: list[Count]) -> str:
    """Instructions a row, by where they come from."""
    lines = [[one.law, *(f"{value:.0f}" for value in one.stages.values()), f"{one.instructions:.0f}"] for one in counts]
    return table(("instructions a row", *STAGES, ALONE, "all"), lines)


def by_kind(counts: list[Count]) -> str:
    """Instructions a row, by what they do, and the floating-point operations in them."""
    lines = [[one.law, *(f"{value:.0f}" for value in one.kinds.values()), f"{one.operations:.0f}"] for one in counts]
    return table(("instructions a row", *KINDS, OTHER, "operations"), lines)


def text(counts: list[Count]) -> str:
    """Both tables, and the count by formula."""
    head = f"{100 * PART_OVER:.0f} % of the rows over the limit; four rows share a vector instruction."
    formula = f"Operations of `Pseudoinverse` by bench/operations.py: {operations.pseudoinverse(11, 8)} a row."
    return "\n\n".join([head, by_stage(counts), by_kind(counts), formula])


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m bench.stages", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rows", type=int, default=ROWS, metavar="N", help="to count over (default %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the counts there")
    asked = parser.parse_args()
    if asked.rows < 4:
        parser.error(f"--rows: {asked.rows}, expected 4 or more")
    counts = count_all(built("rows") / "rows", asked.rows)
    print(text(counts))
    if asked.json:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(json.dumps([asdict(one) for one in counts], indent=1))


if __name__ == "__main__":
    main()
