"""Installs the peers into the environment that runs this. One that cannot be installed here is named and left out."""

import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "requirements"
PINNED, WANTED = FOLDER / "peers.txt", FOLDER / "peers.in"


def pip(*arguments: str) -> str | None:
    """None if it worked, else its last words."""
    command = [sys.executable, "-m", "pip", "install", "-q", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or done.stderr.splitlines()
    return None if done.returncode == 0 else " ".join(said[:2])


def main() -> None:
    if pip("-r", str(PINNED)) is None:
        return
    names = [line.split("==")[0].strip() for line in WANTED.read_text().splitlines() if line and line[0] != "#"]
    reasons = {name: pip(name, "-c", str(PINNED)) for name in names}
    for name, reason in reasons.items():
        if reason is not None:
            print(f"left out: {name} cannot be installed here: {reason}", flush=True)
    if all(reason is not None for reason in reasons.values()):
        sys.exit("no peer can be installed here")


if __name__ == "__main__":
    main()
