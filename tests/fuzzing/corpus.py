"""The sound files that mutations start from: our own arms written out, small files by hand, the ready scenarios."""

import shutil
from importlib import resources
from pathlib import Path

import stillreach as sr

HERE = Path(__file__).parent / "corpus"
READY = Path(str(resources.files("stillreach"))) / "scenarios"
WRITTEN = ("nasa_modular", "canadarm2")


def urdf_files():
    """Contents of URDF files."""
    arms = [*(getattr(sr.arms, name)() for name in WRITTEN), sr.arms.planar(3), sr.arms.snake(30)]
    arms.append(sr.Arm.from_dh([sr.DHRow(a=0.3, alpha=1.2, d=0.1), sr.DHRow(d=0.2, kind="prismatic")]))
    return [arm.to_urdf().encode() for arm in arms] + [path.read_bytes() for path in sorted(HERE.glob("*.urdf"))]


def scenario_files():
    """Contents of scenario files."""
    paths = [*READY.glob("*.toml"), *HERE.glob("*.toml")]
    return [path.read_bytes() for path in sorted(paths, key=lambda path: path.name)]


def set_out(folder):
    """Puts beside each other what scenario files of the corpus name."""
    for path in (HERE / "robot.urdf", HERE / "robot.xml", HERE / "poses.csv", *READY.glob("*.csv")):
        shutil.copy(path, Path(folder) / path.name)
