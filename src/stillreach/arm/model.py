"""The arm: an immutable chain of joints from a base to a tool, and where its tool is and moves."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import IO, TYPE_CHECKING, Any

import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm.describe import describe, headline
from stillreach.arm.dexterity import LEAST_SPEED, LEAST_TURN, Asked, spectra
from stillreach.arm.dh import DHRow, dh_chain
from stillreach.arm.limits import driven, limited
from stillreach.arm.losses import Losses, losses
from stillreach.arm.modules import module_chain
from stillreach.arm.structure import Structure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Arm(Structure):
    """A serial chain of joints. Immutable: its arrays are read-only and ``with_...`` returns another arm.

    Args:
        joints: one or more Joint, from the base on; those without a name become ``j1``, ``j2``, … by place.
        tool: (4, 4) [m] pose of the tool seen from the frame that the last joint moves; None is the identity.
        name: what the arm is called in tables and files.
        followers: joints without a drive, that move with others (mimic joints).

    Raises:
        InputError: no joint, something else than a Joint, two joints of one name, a tool that is not rigid, followers
            of no joint or without a place.
    """

    @classmethod
    def from_modules(
        cls,
        sequence: str,
        lengths: npt.ArrayLike,
        *,
        velocity_limits: npt.ArrayLike | None = None,
        name: str = "modular arm",
    ) -> Arm:
        """An arm of roll and pitch modules, straight up along +z at zero (Bedrossian, 1994).

        Args:
            sequence: R (roll about the link, z) and P (pitch across it, -y), from base to tool.
            lengths: (number of P + 1,) [m] base to first pitch, pitch to pitch, last pitch to tool; or one
                for all. A roll sits in the middle of its segment.
            velocity_limits: (n,) or one for all [rad/s]; None is no limit (others: ``with_limits``).
            name: what the arm is called.

        Raises:
            InputError: another letter, two rolls in one segment, wrong lengths or limits.
        """
        joints, tool = module_chain(sequence, lengths)
        return cls(driven(joints, velocity_limits), tool=tool, name=name)

    @classmethod
    def from_dh(
        cls,
        rows: Iterable[DHRow],
        convention: str = "standard",
        *,
        base: npt.ArrayLike | None = None,
        tool: npt.ArrayLike | None = None,
        velocity_limits: npt.ArrayLike | None = None,
        name: str = "arm",
    ) -> Arm:
        """An arm from Denavit-Hartenberg rows (see ``stillreach.arm.dh`` for both conventions as formulas).

        Args:
            rows: one DHRow for each joint, from the base on.
            convention: ``"standard"`` or ``"modified"`` (Craig).
            base: (4, 4) [m] the table's frame 0 seen from the base; None is the identity.
            tool: (4, 4) [m] the tool seen from the table's frame n; None is the identity.
            velocity_limits: (n,) or one for all [rad/s] or [m/s]; None is no limit (others: ``with_limits``).
            name: what the arm is called.

        Raises:
            InputError: something else than DHRow, another convention, a pose that is not rigid, wrong limits.
        """
        joints, last = dh_chain(rows, convention, base)
        end = last if tool is None else last @ _door.pose("tool", tool)
        return cls(driven(joints, velocity_limits), tool=end, name=name)

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str] | IO[str] | IO[bytes],
        *,
        tip: str | None = None,
        base: str | None = None,
        fixed: Mapping[str, float] | None = None,
    ) -> Arm:
        """The chain between two links of a URDF file; also up one branch of its tree and down another.

        Revolute, continuous and prismatic joints become the arm's, with their names and limits (lower and upper are 0
        where a file of URDF 1.0 or 1.1 has neither; a missing velocity is no limit; from URDF 1.2 on, the smaller of
        acceleration and deceleration counts). A planar joint ``base`` becomes ``base_TX``, ``base_TY``, ``base_RZ``. A
        joint that mimics another one of the chain becomes a ``Follower``: the two are one joint of the arm, within the
        limits of both, where these leave it a range. One that mimics a joint outside the chain stands still: where a
        leader at 0, or at its position in ``fixed``, puts it.

        Args:
            path: the file, its text (which begins with ``<``) or a file object, e.g. ``sys.stdin.buffer``. Meshes are
                not looked at.
            tip: link whose frame is the tool; None takes the only link that has no child below the base.
            base: link that poses are seen from; None takes the root.
            fixed: joints held at a position [rad] or [m], which are then no joints of the arm; also leaders outside it.

        Raises:
            RobotFileError: if the file cannot be read, is malformed, hostile, xacro or of an unknown version, is not a
                tree, or has no such chain; the error names file, line, element and the valid choices.
        """
        from stillreach.arm.urdf import chain

        return cls(**chain(path, tip, base, fixed)._asdict())

    @classmethod
    def from_mjcf(
        cls,
        path_or_model: Any,
        *,
        tip: str | None = None,
        base: str | None = None,
        fixed: Mapping[str, float] | None = None,
    ) -> Arm:
        """The chain between two bodies of an MJCF file, as MuJoCo reads it (extra ``mujoco``).

        Hinges and slides become the arm's joints, with their names and ranges; MJCF has no velocity limits
        (``with_limits`` sets them). Joints that an equality constraint couples follow each other.

        Args:
            path_or_model: the file (meshes need not be there), its text (begins with ``<``), a file object, a
                ``mujoco.MjSpec`` or a ``mujoco.MjModel``.
            tip: body or site whose frame is the tool; None takes the only body that has no child.
            base: body that poses are seen from; None takes the world.
            fixed: joints held at a position [rad] or [m], which are then no joints of the arm.

        Raises:
            MissingExtraError: if MuJoCo is not installed.
            RobotFileError: as of ``from_urdf``; or if a free or ball joint is between base and tip.
        """
        from stillreach.arm.mjcf import chain

        return cls(**chain(path_or_model, tip, base, fixed)._asdict())

    def to_urdf(self, path: str | os.PathLike[str] | None = None) -> str:
        """The arm as URDF, which ``from_urdf`` reads back, and MuJoCo and other readers, too.

        It is URDF 1.0, or 1.2 where a joint has an acceleration limit. Links have no mass; in MuJoCo each gets 1 kg.

        Args:
            path: where to write it; None writes nothing.

        Returns:
            The text of the file. A limit of 1e9 stands for none.

        Raises:
            InputError: if a name holds characters that XML cannot hold.
            OSError: if the file cannot be written.
        """
        from stillreach.arm.urdf_write import write_urdf

        return write_urdf(self, path)

    def forward(self, q: npt.ArrayLike) -> FloatArray:
        """Pose of the tool in the base frame.

        Args:
            q: (..., n) joint values [rad] or [m]; or by joint name: a mapping, a pandas Series, a DataFrame with a
                column for each joint.

        Returns:
            (..., 4, 4) [m].

        Raises:
            InputError: another shape, not numbers, NaN or infinite.
        """
        return self._each(self.model.forward, q, (4, 4))

    def jacobian(self, q: npt.ArrayLike) -> FloatArray:
        """Twist of the tool per joint rate: [v; w] of the tool point, along base axes.

        Args:
            q: (..., n) joint values [rad] or [m], or by joint name, as of ``forward``.

        Returns:
            (..., 6, n); a revolute column is in [m/rad] and [1], a prismatic one in [1] and [rad/m] (zero).

        Raises:
            InputError: another shape, not numbers, NaN or infinite.
        """
        return self._each(self.model.jacobian, q, (6, self.n))

    def singular_values(
        self, q: npt.ArrayLike, task: Asked | None = None, *, joints: Iterable[str | int] | None = None
    ) -> FloatArray:
        """How fast unit joint rates move the tool: from the direction served best to the one served worst.

        Args:
            q: (..., n) joint values [rad] or [m], or by joint name, as of ``forward``.
            task: rows, axes, point and weights; None: all six rows at the arm's tool, in metres and radians.
            joints: k names or indices of the joints that work; None: all.

        Returns:
            (..., min(m, k)) singular values of these joints' weighted Jacobian, falling.

        Raises:
            InputError: another shape, not numbers, NaN or infinite; a joint twice.
            UnknownJointError: the arm has no such joint.
        """
        return spectra(self, q, task, joints, product=False)

    def manipulability(
        self, q: npt.ArrayLike, task: Asked | None = None, *, joints: Iterable[str | int] | None = None
    ) -> FloatArray:
        """The root of det(J Jᵀ) of the weighted Jacobian: the product of its m singular values (Yoshikawa, 1985).

        Arguments and errors are those of ``singular_values``.

        Returns:
            (...,) array; 0 where a direction of the task is lost, as with fewer joints than rows.
        """
        return spectra(self, q, task, joints, product=True)

    def losses(
        self,
        q: npt.ArrayLike | None = None,
        task: Asked | None = None,
        *,
        lost_below: tuple[float, float] = (LEAST_SPEED, LEAST_TURN),
    ) -> Losses:
        """What the loss of each joint costs: remaining manipulability, and directions that are lost.

        Args:
            q: (n,) joint values [rad] or [m], or by joint name; None: where the arm moves best, of a sample of its
                range.
            task: rows, axes and point; None: all six rows at the arm's tool.
            lost_below: speeds [m/s] and [rad/s]; a direction in which full rates give less is lost. Joints without a
                rate limit count with 1 rad/s or 1 m/s.

        Returns:
            What is left without each joint; ``print`` shows it as a table with a verdict.

        Raises:
            InputError: if an argument is invalid.
        """
        return losses(self, q, task, lost_below)

    def plot(self, q: npt.ArrayLike, *, failed: Iterable[str | int] = ()) -> Figure:
        """A picture of the arm.

        Args:
            q: (n,) joint values [rad] or [m], or by joint name.
            failed: names or indices of joints to draw as failed.

        Raises:
            InputError: if an argument is invalid.
            MissingExtraError: matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.scene import arm_picture

        at = _door.vector("q", q, self.n, labels=self.labels)
        return arm_picture(self, at, [self.joint_index(joint) for joint in failed])

    def with_limits(
        self,
        *,
        velocity: npt.ArrayLike | None = None,
        position: npt.ArrayLike | None = None,
        acceleration: npt.ArrayLike | None = None,
    ) -> Arm:
        """The same arm with other limits; None keeps what it has.

        Args:
            velocity: (n,) or one for all [rad/s] or [m/s], at least 0; 0 means that the joint cannot move.
            position: (n, 2) or one pair (lower, upper) for all [rad] or [m].
            acceleration: (n,) or one for all [rad/s²] or [m/s²], at least 0.

        Raises:
            InputError: wrong shape, NaN, a negative rate, or lower above upper.
        """
        joints = limited(self.joints, velocity=velocity, position=position, acceleration=acceleration)
        return Arm(joints, tool=self.tool, name=self.name, followers=self.followers)

    def with_tool(self, tool: npt.ArrayLike) -> Arm:
        """The same arm with another tool in place of the one it has.

        Many arms have their last link in ``tool``: ``arm.with_tool(arm.tool @ T)`` adds T to its end.

        Args:
            tool: (4, 4) [m] pose of the tool seen from the frame that the last joint moves.

        Raises:
            InputError: it is not a rigid transform.
        """
        return Arm(self.joints, tool=tool, name=self.name, followers=self.followers)

    def describe(self) -> str:
        """A table of the joints, their axes and limits, and the reach; ``str(arm)`` is the same."""
        return describe(self)

    def _each(
        self, compute: Callable[[FloatArray], FloatArray], q: npt.ArrayLike, shape: tuple[int, int]
    ) -> FloatArray:
        """Run a function of many configurations (N, n) on an array (..., n)."""
        many = _door.configurations("q", q, self.labels)
        return compute(many.reshape(-1, self.n)).reshape(many.shape[:-1] + shape)

    def __repr__(self) -> str:
        return f"<Arm {headline(self)}>"

    def __str__(self) -> str:
        return describe(self)
