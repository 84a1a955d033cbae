"""One file a peer. This list says what is timed, in the order of the tables."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class Entry:
    """A line of a table: its key, its title, the module and class that answer it."""

    key: str
    title: str
    module: str
    name: str = "Peer"
    ours: bool = False
    package: str = "bench.peers"

    def load(self) -> type[Any]:
        """The class; this imports the peer's library."""
        return getattr(import_module(f"{self.package}.{self.module}"), self.name)


TICKS = (
    Entry("ours-bound", "stillreach, `LeastError(price=None)`, bound buffers", "ours", "Bound", ours=True),
    Entry("ours-new", "stillreach, `LeastError(price=None)`, new array", "ours", "NewArray", ours=True),
    Entry("default-bound", "stillreach, `LeastError()`, bound buffers", "ours", "DefaultBound", ours=True),
    Entry("default-new", "stillreach, `LeastError()`, new array", "ours", "DefaultNewArray", ours=True),
    Entry("pinocchio-daqp", "Pinocchio + daqp, called directly", "pinocchio_daqp"),
    Entry("pinocchio-numpy", "Pinocchio + NumPy, damped, scaled to the limit", "pinocchio_numpy"),
    Entry("placo", "placo", "placo"),
    Entry("robotics-toolbox", "Robotics Toolbox + quadprog", "robotics_toolbox"),
    Entry("embodik", "EmbodiK", "embodik"),
    Entry("mink", "mink (daqp), a twist task of one's own", "mink"),
    Entry("mink-frame", "mink (daqp), `FrameTask`", "mink", "FrameTaskPeer"),
    Entry("pink", "Pink (quadprog), a twist task of one's own", "pink"),
    Entry("pink-frame", "Pink (quadprog), `FrameTask`", "pink", "FrameTaskPeer"),
    Entry("drake", "Drake, differential inverse kinematics", "drake"),
)

BATCHES = (
    Entry("ours-batch", "stillreach, `LeastError(price=None)`", "ours", "Batch", ours=True),
    Entry("ours-batch-exact", "stillreach, `SingularityRobust`, exact", "ours", "BatchExact", ours=True),
    Entry("ours-batch-pinv", "stillreach, `Pseudoinverse`", "ours", "BatchPseudoinverse", ours=True),
    Entry("jax", "JAX, jit + vmap, damped, scaled to the limit", "jax"),
    Entry("pytorch-kinematics", "pytorch-kinematics, damped, scaled to the limit", "pytorch_kinematics"),
    Entry("numpy", "NumPy, vectorised, damped, scaled to the limit", "numpy_batch"),
)

ENTRIES = {entry.key: entry for entry in (*TICKS, *BATCHES)}
