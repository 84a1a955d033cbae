"""The kernel alone: the common rows through C++, 256 at a time, without Python."""

import subprocess
import tempfile
from pathlib import Path

from bench.machine import built
from bench.rows import Rows

LAWS = {
    "pseudoinverse": "`Pseudoinverse`",
    "exact": "`SingularityRobust`, exact",
    "closed form": "`SingularityRobust`, closed form",
    "number": "`SingularityRobust`, κ given",
    "least error": "`LeastError()`",
    "bare least error": "`LeastError(price=None)`",
    "keep direction": "`KeepDirection`",
}
"""The laws as rows.cpp calls them, and as the tables do."""


def kernel_times(rows: Rows, repeats: int) -> dict[str, float]:
    """[µs] a row by law: minima of pieces of 256 rows, which fit between what else the machine does."""
    program, found = built("rows") / "rows", {}
    with tempfile.TemporaryDirectory() as folder:
        rows.write(file := Path(folder) / "rows")
        for law, title in LAWS.items():
            command = [str(program), str(file), str(len(rows)), law, str(repeats)]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            found[title] = float(done.stdout.rsplit(maxsplit=1)[1]) / 1e3
    return found
