"""The arm: an immutable chain of joints from a base to a tool, with its kinematics."""

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
from stillreach.arm.shapes import Shape, shapes
from stillreach.arm.structure import Structure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stillreach.faults import FaultKind
    from stillreach.inverse_result import Inverse
    from stillreach.page import Page
    from stillreach.task import Task


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Arm(Structure):
    """A serial chain of joints. Immutable: its arrays are read-only and ``with_...`` returns another arm.

    Args:
        joints: one or more Joint, from the base on; those without a name become ``j1``, ``j2``, … by position.
        tool: (4, 4) [m] pose of the tool in the frame that the last joint moves; None is the identity.
        name: the arm's name in tables and files.
        followers: joints without a drive that move with others (mimic joints).

    Raises:
        InputError: if joints are missing, an item is not a Joint, a name is repeated, the tool is not rigid, or a
            follower is invalid.
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
            name: the arm's name.

        Raises:
            InputError: if a letter, length or limit is invalid, or a segment has two rolls.
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
            base: (4, 4) [m] the table's frame 0 in the base frame; None is the identity.
            tool: (4, 4) [m] the tool in the table's frame n; None is the identity.
            velocity_limits: (n,) or one for all [rad/s] or [m/s]; None is no limit (others: ``with_limits``).
            name: the arm's name.

        Raises:
            InputError: if an item is not a DHRow, the convention is unknown, a pose is not rigid or a limit is invalid.
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
        """The chain between two links of a URDF file; it may go up one branch of the tree and down another.

        Revolute, continuous and prismatic joints become the arm's, with their names and limits (lower and upper are 0
        where a file of URDF 1.0 or 1.1 has neither; a missing velocity is no limit; from URDF 1.2 on, the smaller of
        acceleration and deceleration counts). A planar joint ``base`` becomes ``base_TX``, ``base_TY``, ``base_RZ``. A
        joint that mimics another one of the chain becomes a ``Follower``: the two are one joint of the arm, within the
        limits of both, where these leave it a range. One that mimics a joint outside the chain stands still: where a
        leader at 0, or at its position in ``fixed``, puts it.

        Args:
            path: the file, its text (which begins with ``<``) or a file object, e.g. ``sys.stdin.buffer``. Meshes are
                ignored.
            tip: link whose frame is the tool; None: the only link without children below the base.
            base: link that poses refer to; None: the root.
            fixed: joints held at a position [rad] or [m] and left out of the arm; also leaders outside it.

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
            path_or_model: the file (meshes may be missing), its text (begins with ``<``), a file object, a
                ``mujoco.MjSpec`` or a ``mujoco.MjModel``.
            tip: body or site whose frame is the tool; None: the only body without children.
            base: body that poses refer to; None: the world.
            fixed: joints held at a position [rad] or [m] and left out of the arm.

        Raises:
            MissingExtraError: if MuJoCo is not installed.
            RobotFileError: as ``from_urdf``; or if a free or ball joint is between base and tip.
        """
        from stillreach.arm.mjcf import chain

        return cls(**chain(path_or_model, tip, base, fixed)._asdict())

    def to_urdf(self, path: str | os.PathLike[str] | None = None) -> str:
        """The arm as URDF, for ``from_urdf``, MuJoCo and other readers.

        It is URDF 1.0, or 1.2 where a joint has an acceleration limit. Links have no mass; in MuJoCo each gets 1 kg.

        Args:
            path: the file to write; None writes nothing.

        Returns:
            The text of the file. A limit of 1e9 means no limit.

        Raises:
            InputError: if a name has characters that XML does not allow.
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
            InputError: if the shape is wrong or a value is not a finite number.
        """
        return self._each(self.model.forward, q, (4, 4))

    def jacobian(self, q: npt.ArrayLike) -> FloatArray:
        """Twist of the tool per joint rate: [v; w] of the tool point, along base axes.

        Args:
            q: (..., n) joint values [rad] or [m], or by joint name, as for ``forward``.

        Returns:
            (..., 6, n); a revolute column is in [m/rad] and [1], a prismatic one in [1] and [rad/m] (zero).

        Raises:
            InputError: if the shape is wrong or a value is not a finite number.
        """
        return self._each(self.model.jacobian, q, (6, self.n))

    def inverse(
        self,
        poses: npt.ArrayLike,
        start: npt.ArrayLike | None = None,
        *,
        locked: Iterable[str | int] | Mapping[str | int, npt.ArrayLike] = (),
        faults: Mapping[str | int, FaultKind] | None = None,
        task: Task | None = None,
        starts: int = 100,
        tolerance: float = 1e-9,
        nearest: bool = False,
        solutions: int = 1,
        apart: float = 1e-3,
        seed: int = 0,
        threads: int | None = None,
    ) -> Inverse:
        """Joint positions that bring the tool to poses, within the position limits: the counterpart of ``forward``.

        Gauss-Newton steps, each the least pose error inside limits and a trust region, from ``start`` and then from
        random configurations. A result depends on its pose alone, not on the other poses or the number of threads.

        Args:
            poses: (..., 4, 4) [m] of the tool (or the task's point) in the base frame.
            start: (n,) or (..., n) [rad, m] where the first search begins, or by joint name; None: at random.
            locked: joints that stand still: names or indices, at their position in ``start``; or a mapping of joints
                to positions [rad, m], one each, or several of which any will do.
            faults: kinds of faults by joint: ``Locked`` (at its position in ``start``), ``Confined``, ``OneWay`` (from
                its position in ``start``), ``Derated`` (which does not limit positions).
            task: rows, frame, point and weights; None: all six rows at the arm's tool.
            starts: the most searches for a pose; more find more of the difficult ones.
            tolerance: [m, rad] largest entry of the error of a pose that counts as reached.
            nearest: search for the configuration nearest to ``start``, rather than for any.
            solutions: how many different configurations to find.
            apart: [rad, m] the least largest joint difference between two different configurations.
            seed: of the random starts.
            threads: how many to use; None: the environment's STILLREACH_THREADS, or the processors at hand.

        Returns:
            The configurations, which poses were reached, and why others were not.

        Raises:
            InputError: if an argument is invalid.
            UnknownJointError: if the arm has no such joint.
        """
        from stillreach.inverse import inverse

        return inverse(
            self, poses, start, locked, faults or {}, task, starts, tolerance, nearest, solutions, apart, seed, threads
        )

    def singular_values(
        self, q: npt.ArrayLike, task: Asked | None = None, *, joints: Iterable[str | int] | None = None
    ) -> FloatArray:
        """Tool speeds for unit joint rates, from the best served direction to the worst.

        Args:
            q: (..., n) joint values [rad] or [m], or by joint name, as for ``forward``.
            task: rows, frame, point and weights; None: all six rows at the arm's tool, in metres and radians.
            joints: k names or indices of the working joints; None: all.

        Returns:
            (..., min(m, k)) singular values of these joints' weighted Jacobian, descending.

        Raises:
            InputError: if the shape is wrong, a value is not a finite number, or a joint is repeated.
            UnknownJointError: if the arm has no such joint.
        """
        return spectra(self, q, task, joints, product=False)

    def manipulability(
        self, q: npt.ArrayLike, task: Asked | None = None, *, joints: Iterable[str | int] | None = None
    ) -> FloatArray:
        """The square root of det(J Jᵀ) of the weighted Jacobian, the product of its m singular values (Yoshikawa).

        Arguments and errors are those of ``singular_values``.

        Returns:
            (...,) array; 0 if a direction of the task is lost or there are fewer joints than rows.
        """
        return spectra(self, q, task, joints, product=True)

    def losses(
        self,
        q: npt.ArrayLike | None = None,
        task: Asked | None = None,
        *,
        lost_below: tuple[float, float] = (LEAST_SPEED, LEAST_TURN),
    ) -> Losses:
        """The cost of losing each joint: remaining manipulability and lost directions.

        Args:
            q: (n,) joint values [rad] or [m], or by joint name; None: the best configuration in a sample of the
                range.
            task: rows, frame and point; None: all six rows at the arm's tool.
            lost_below: speeds [m/s] and [rad/s]; a direction in which full rates give less counts as lost. Joints
                without a velocity limit count with 1 rad/s or 1 m/s.

        Returns:
            The loss of each joint; ``print`` shows a table and a verdict.

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
            MissingExtraError: if matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.scene import arm_picture

        at = _door.vector("q", q, self.n, labels=self.labels)
        return arm_picture(self, at, [self.joint_index(joint) for joint in failed])

    def shapes(self, q: npt.ArrayLike) -> list[Shape]:
        """Capsules and cylinders that show the arm in a viewer of your own, always in the same number and order.

        Args:
            q: (n,) joint values [rad] or [m], or by joint name.

        Returns:
            The links from the base to the tool as capsules, then the joints as cylinders along their axes: named
            tuples ``(name, joint, pose, length, radius)``.

        Raises:
            InputError: if q is invalid.
        """
        return shapes(self, _door.vector("q", q, self.n, labels=self.labels))

    def page(self, q: npt.ArrayLike | None = None) -> Page:
        """A page that runs the controller of this arm in a browser, and in which a click breaks a joint.

        Args:
            q: (n,) joint values [rad] or [m] to start from, or by joint name; None: far from singularities and limits.

        Raises:
            InputError: if q is invalid.
            PageNotBuiltError: if this installation has no program for it.
        """
        from stillreach.page import arm_page

        return arm_page(self, q)

    def with_limits(
        self,
        *,
        velocity: npt.ArrayLike | None = None,
        position: npt.ArrayLike | None = None,
        acceleration: npt.ArrayLike | None = None,
    ) -> Arm:
        """The same arm with other limits; None keeps the present ones.

        Args:
            velocity: (n,) or one for all [rad/s] or [m/s], at least 0; 0 means that the joint cannot move.
            position: (n, 2) or one pair (lower, upper) for all [rad] or [m].
            acceleration: (n,) or one for all [rad/s²] or [m/s²], at least 0.

        Raises:
            InputError: if a shape is wrong, a value is NaN, a velocity is negative, or lower is above upper.
        """
        joints = limited(self.joints, velocity=velocity, position=position, acceleration=acceleration)
        return Arm(joints, tool=self.tool, name=self.name, followers=self.followers)

    def with_tool(self, tool: npt.ArrayLike) -> Arm:
        """The same arm with another tool.

        ``tool`` often includes the last link: ``arm.with_tool(arm.tool @ T)`` adds T to its end.

        Args:
            tool: (4, 4) [m] pose of the tool in the frame that the last joint moves.

        Raises:
            InputError: if the tool is not a rigid transform.
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
