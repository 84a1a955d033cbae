"""What the machine can do, measured beside what is compared with it: clock and rate of multiply-adds."""

import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
BUILD = ROOT / "build" / "bench"


def built(*targets: str) -> Path:
    """The folder with these programs of bench/CMakeLists.txt, built if they are not.

    Raises:
        SystemExit: CMake or the compiler failed; says what they said.
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    configure = ["cmake", "-S", str(ROOT), "-B", str(BUILD), "-G", "Ninja", "-DSTILLREACH_BENCH=ON"]
    configure.append("-DCMAKE_CXX_FLAGS=-g")  # tells inlined functions apart, and changes no instruction
    for command in (configure, ["cmake", "--build", str(BUILD), "--target", *targets]):
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, check=False, env={**os.environ, "PATH": path}
            )
        except FileNotFoundError:
            raise SystemExit("cmake is missing; `make wheel` says how to install what a build needs") from None
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")
    return BUILD / "bench"


@dataclass
class Peak:
    """The best of several runs of peak.cpp, spread over the time of a measurement, on the core of this process.

    clock [GHz]; peak [GFLOP/s] of multiply-adds in registers of four numbers; peak_of_eight: of eight, 0 where there
    are none.
    """

    clock: float = 0.0
    peak: float = 0.0
    peak_of_eight: float = 0.0
    clocks: list[float] = field(default_factory=list)

    def look(self) -> None:
        """Measures once more."""
        done = subprocess.run(
            [built("peak") / "peak" if not self.clocks else BUILD / "bench" / "peak"],
            capture_output=True,
            text=True,
            check=True,
        )
        found = {name: float(value) for name, value in (line.split() for line in done.stdout.splitlines())}
        for name, value in found.items():
            setattr(self, name, max(value, getattr(self, name)))
        self.clocks.append(found["clock"])

    def cycles(self, microseconds: float) -> float:
        """At the best clock seen."""
        return 1e3 * microseconds * self.clock
