"""Robot files: how an arm comes from one, and goes into one."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import IO, TYPE_CHECKING, Any, Self, cast

if TYPE_CHECKING:
    import numpy.typing as npt

    from stillreach.arm.follower import Follower
    from stillreach.arm.joint import Joint
    from stillreach.arm.model import Arm


class RobotFiles:
    """The part of ``Arm`` that reads and writes robot files; what does the work is imported when it is needed."""

    if TYPE_CHECKING:

        def __init__(
            self,
            joints: Iterable[Joint],
            *,
            tool: npt.ArrayLike | None = ...,
            name: str = ...,
            followers: Iterable[Follower] = ...,
        ) -> None: ...

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str] | IO[str] | IO[bytes],
        *,
        tip: str | None = None,
        base: str | None = None,
        fixed: Mapping[str, float] | None = None,
    ) -> Self:
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
            RobotFileError: the file cannot be read, is malformed, hostile, xacro or of an unknown version, is no tree,
                or has no such chain; the error names file, line, element and the valid choices.
        """
        from stillreach.arm.urdf import urdf_chain

        joints, tool, name, followers = urdf_chain(path, tip, base, fixed)
        return cls(joints, tool=tool, name=name, followers=followers)

    @classmethod
    def from_mjcf(
        cls,
        path_or_model: Any,
        *,
        tip: str | None = None,
        base: str | None = None,
        fixed: Mapping[str, float] | None = None,
    ) -> Self:
        """The chain between two bodies of an MJCF file, as MuJoCo reads it (extra ``mujoco``).

        Hinges and slides become the arm's joints, with their names and ranges; MJCF knows no velocity limits
        (``with_limits`` sets them). Joints that an equality constraint couples follow each other.

        Args:
            path_or_model: the file (meshes need not be there), its text (begins with ``<``), a file object, a
                ``mujoco.MjSpec`` or a ``mujoco.MjModel``.
            tip: body or site whose frame is the tool; None takes the only body that has no child.
            base: body that poses are seen from; None takes the world.
            fixed: joints held at a position [rad] or [m], which are then no joints of the arm.

        Raises:
            MissingExtraError: MuJoCo is not installed.
            RobotFileError: as for ``from_urdf``; or a free or ball joint is between base and tip.
        """
        from stillreach.arm.mjcf import mjcf_chain

        joints, tool, name, followers = mjcf_chain(path_or_model, tip, base, fixed)
        return cls(joints, tool=tool, name=name, followers=followers)

    def to_urdf(self, path: str | os.PathLike[str] | None = None) -> str:
        """The arm as URDF, which ``from_urdf`` reads back, and MuJoCo and other readers, too.

        It is URDF 1.0, or 1.2 where a joint has an acceleration limit. Links have no mass; in MuJoCo each gets 1 kg.

        Args:
            path: where to write it; None writes nothing.

        Returns:
            The text of the file. A limit of 1e9 stands for none.

        Raises:
            InputError: a name holds characters that XML cannot hold.
            OSError: the file cannot be written.
        """
        from stillreach.arm.urdf_write import write_urdf

        return write_urdf(cast("Arm", self), path)
