"""A recording: joint positions of an arm over time, from another tool's file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._files import file_name
from stillreach.arm import Arm
from stillreach.errors import InputError
from stillreach.recordings.samples import Samples, in_si
from stillreach.simulation.pose_table import PoseTable

if TYPE_CHECKING:
    from stillreach.simulation import Scenario

GAP_STEPS, GAP = 10.0, 0.1
"""A gap is longer than this many of the recording's median steps, and than this [s]."""
BEYOND = 0.1
"""[rad, m] that a recorded position may be beyond its limit: encoders and limits of files are not exact."""


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Joint positions over time. Immutable.

    Args:
        arm: the arm.
        time: (T,) [s] rising; shifted so that it begins at 0.
        q: (T, n) [rad] or [m], or columns by joint name.
        name: what it is called in pictures and files.
        largest_gap: [s] between two samples; None: 10 median steps, but at least 0.1 s.
        allow_outside: whether positions may be more than 0.1 rad or m beyond the arm's position limits.

    Raises:
        InputError: if times do not rise or have a gap, or positions are far beyond the limits, with advice.
    """

    arm: Arm
    time: FloatArray
    q: FloatArray
    name: str = ""
    cut: bool = False
    """Whether the file ended before its end, as a crash leaves it."""

    def __init__(
        self,
        arm: Arm,
        time: npt.ArrayLike,
        q: npt.ArrayLike,
        *,
        name: str = "",
        largest_gap: float | None = None,
        allow_outside: bool = False,
    ) -> None:
        if not isinstance(arm, Arm):
            raise InputError("arm", _door.describe(arm), "an Arm")
        places = _door.configurations("q", q, arm.labels)
        if places.ndim != 2 or len(places) < 2:
            raise InputError("q", _door.describe(q), f"positions (T, {arm.n}) of at least two samples")
        moments = _door.vector("time", time, len(places), one_for_all=False)
        _check_times(moments, "sample", 0, largest_gap)
        if not allow_outside:
            _check_limits(arm, moments, places)
        object.__setattr__(self, "arm", arm)
        object.__setattr__(self, "time", _door.frozen(moments - moments[0]))
        object.__setattr__(self, "q", _door.frozen(places))
        object.__setattr__(self, "name", _door.text("name", name))

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        *,
        arm: Arm,
        angle: str | None = None,
        length: str = "m",
        joints: Mapping[str, str] | None = None,
        topic: str | None = None,
        episode: int | None = None,
        sort: bool = False,
        largest_gap: float | None = None,
        allow_outside: bool = False,
    ) -> Recording:
        """Read a recording, by joint name.

        =============================  ======================================================================
        a folder, ``.mcap``, ``.db3``   a rosbag2 with ``sensor_msgs/msg/JointState`` (extra ``recordings``)
        ``.csv``, ``.txt``, ``.tsv``   a column ``time`` and one of each joint
        ``.parquet``                   the same, or a LeRobot dataset's ``observation.state`` (extra ``recordings``)
        ``.nc``, ``.npz``              a run that stillreach saved
        =============================  ======================================================================

        Args:
            path: file or folder.
            arm: whose joints are read.
            angle: ``"rad"`` or ``"deg"``: the unit of angles where the file does not say it, as in ``j4 [deg]``.
                Messages of ROS and runs are in rad.
            length: unit of prismatic joints where the file does not say it.
            joints: the file's name of each joint of the arm that is called otherwise there.
            topic: of the joint states, where a bag has several.
            episode: of a dataset with several.
            sort: put samples in the order of their times, and of several at one time keep the last.
            largest_gap: [s] between two samples; None: 10 median steps, but at least 0.1 s.
            allow_outside: whether positions may be more than 0.1 rad or m beyond the arm's position limits.

        Raises:
            InputError: if the file is not such a recording; the message says what to do.
            FileNotFoundError: if it is missing.
            MissingExtraError: if the package that reads it is not installed.
        """
        if not isinstance(arm, Arm):
            raise InputError("arm", _door.describe(arm), "an Arm")
        if angle is not None:
            _door.choice("angle", angle, ("rad", "deg"))
        _door.choice("length", length, ("m", "cm", "mm", "in", "ft"))
        named = _named(arm, joints or {})
        file = Path(file_name("path", path))
        if not file.exists():
            raise FileNotFoundError(2, "no such recording", str(file))
        reader = _reader(file)
        for option, value in (("topic", topic), ("episode", episode)):
            if value is not None and option != reader.option:
                raise InputError(option, repr(value), f"none for {file.name}")
        samples = reader.read(file, arm.joint_names, named, topic if reader.option == "topic" else episode)
        samples = _sorted(samples) if sort else samples
        _check_times(samples.time, samples.row, samples.first, largest_gap)
        revolute = [unit == "rad" for unit in arm.joint_units]
        q = in_si(samples, arm.joint_names, revolute, angle, length)
        _check_finite(samples, q, arm)
        made = cls(arm, samples.time, q, name=file.stem, largest_gap=np.inf, allow_outside=allow_outside)
        object.__setattr__(made, "cut", samples.cut)
        return made

    @staticmethod
    def tool_motion(
        path: str | os.PathLike[str],
        *,
        topic: str | None = None,
        frame: str | None = None,
        child: str | None = None,
        sort: bool = False,
        largest_gap: float | None = None,
    ) -> PoseTable:
        """The motion of a tool from a rosbag2 that has its poses, and not joints, as a task.

        Args:
            path: folder or file with ``PoseStamped``, ``TransformStamped`` or ``TFMessage`` (extra ``recordings``).
            topic: of the poses, where there are several; with ``/tf``, ``/tf_static`` counts as well.
            frame: the arm's base, in which the poses are; None: the frame of the messages, or the root of the tree.
            child: of transforms, the frame of the tool; None: the only end of the tree.
            sort: put poses in the order of their times, and of several at one time keep the last.
            largest_gap: [s] between two poses; None: 10 median steps, but at least 0.1 s.

        Returns:
            A motion whose first pose is at time 0: a scenario has to start there, e.g. at ``arm.inverse`` of it.

        Raises:
            InputError: if the file is not such a recording; the message says what to do.
            FileNotFoundError: if it is missing.
            MissingExtraError: if the package that reads it is not installed.
        """
        from stillreach.recordings.poses import read

        file = Path(file_name("path", path))
        if not file.exists():
            raise FileNotFoundError(2, "no such recording", str(file))
        if _reader(file).option != "topic":
            raise InputError("path", repr(file.name), "a rosbag2 folder or file")
        times, poses = read(file, topic, frame, child)
        keep = _last_of_each(times) if sort else np.arange(len(times))
        times, poses = times[keep] - times[keep[0]], poses[keep]
        _check_times(times, "pose", 0, largest_gap)
        return PoseTable(times, poses[:, :3, 3], orientations=poses[:, :3, :3])

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        return f"<Recording of {self.arm.name}, {len(self)} samples in {self.duration:g} s>"

    @property
    def start(self) -> FloatArray:
        """(n,) the first positions [rad] or [m]."""
        return _door.frozen(self.q[0])

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.time[-1])

    def at(self, times: npt.ArrayLike) -> FloatArray:
        """Positions (K, n) at times (K,) [s]: linear between two samples, and those of the ends beyond them."""
        moments = np.asarray(_door.array("times", times, "times (K,)"), dtype=float)
        if moments.ndim != 1:
            raise InputError("times", _door.describe(times), "times (K,)")
        return np.stack([np.interp(moments, self.time, column) for column in self.q.T], axis=1)

    def as_motion(self, *, every: float | None = None, tool: npt.ArrayLike | None = None) -> PoseTable:
        """The tool's poses over time as a task.

        Args:
            every: [s] between two poses: joint positions are linear between two samples; None: a pose a sample. Between
                poses the tool moves on straight lines.
            tool: (4, 4) pose of the task's point seen from the tool, as in ``Task(tool=...)``; None: the tool itself.

        Raises:
            InputError: if an argument is invalid.
        """
        times = self.time
        if every is not None:
            step = _door.positive("every", every)
            if step > self.duration:
                raise InputError("every", f"{step:g}", f"at most the recording's {self.duration:g} s")
            times = np.append(np.arange(0.0, self.duration - 1e-6 * step, step), self.duration)
        poses = self.arm.forward(self.q if every is None else self.at(times))
        if tool is not None:
            poses = poses @ _door.pose("tool", tool)
        return PoseTable(times, poses[:, :3, 3], orientations=poses[:, :3, :3])

    def scenario(self, **settings: Any) -> Scenario:
        """A scenario whose task is the recorded motion of the tool, in closed loop, from the recorded start.

        Args:
            settings: of ``Scenario``, such as ``faults``; they replace those of the recording.

        Raises:
            InputError: if a setting is invalid.
        """
        from stillreach.simulation import Scenario

        task = settings.get("task")
        motion = self.as_motion(tool=getattr(task, "tool", None))
        defaults = {"start": self.start, "motion": motion, "loop": "closed", "name": self.name}
        return Scenario(arm=self.arm, **{**defaults, **settings})


class _Reader:
    """How files of one kind are read: ``read`` takes the file, the joints, other names of them and the option."""

    def __init__(self, module: str, option: str = "") -> None:
        self.module = module
        self.option = option

    def read(self, file: Path, joints: tuple[str, ...], named: Mapping[str, str], option: Any) -> Samples:
        from importlib import import_module

        read = import_module(f"stillreach.recordings.{self.module}").read
        samples: Samples = read(file, joints, named, option)
        return samples


READERS = {
    ".mcap": _Reader("rosbag", "topic"),
    ".db3": _Reader("rosbag", "topic"),
    ".csv": _Reader("columns"),
    ".txt": _Reader("columns"),
    ".tsv": _Reader("columns"),
    ".parquet": _Reader("parquet", "episode"),
    ".nc": _Reader("saved"),
    ".npz": _Reader("saved"),
}
"""By suffix."""


def _reader(file: Path) -> _Reader:
    if file.is_dir():
        return READERS[".mcap"]
    if file.suffix.lower() not in READERS:
        raise InputError("path", repr(file.name), f"a rosbag2 folder or a file that ends with {', '.join(READERS)}")
    return READERS[file.suffix.lower()]


def _named(arm: Arm, joints: Mapping[str, str]) -> dict[str, str]:
    """Other names of joints, checked."""
    if not isinstance(joints, Mapping):
        raise InputError("joints", _door.describe(joints), "a mapping from the arm's joints to the file's names")
    named = {arm.joint_names[arm.joint_index(joint)]: name for joint, name in joints.items()}
    for name in named.values():
        _door.text("joints", name)
    return named


def _last_of_each(times: FloatArray) -> npt.NDArray[np.intp]:
    """Places of times (K,) in their order, of several at one time the last."""
    order = np.argsort(times, kind="stable")
    last: npt.NDArray[np.intp] = order[np.append(np.diff(times[order]) > 0.0, True)]
    return last


def _sorted(samples: Samples) -> Samples:
    keep = _last_of_each(samples.time)
    return replace(samples, time=samples.time[keep], columns=samples.columns[keep])


def _check_times(time: FloatArray, row: str, first: int, largest_gap: float | None) -> None:
    """Raises InputError unless times rise without a gap."""
    if len(time) < 2:
        raise InputError("path", f"{len(time)} {row}{'' if len(time) == 1 else 's'}", "at least two")
    if not np.isfinite(time).all():
        place = int(np.argmin(np.isfinite(time)))
        raise InputError("time", f"{time[place]} in {row} {place + first}", "finite times")
    steps = np.diff(time)
    if steps.min() <= 0.0:
        place = int(np.argmax(steps <= 0.0))
        what = "the same time" if steps[place] == 0.0 else "an earlier time"
        others = int(np.sum(steps <= 0.0)) - 1
        more = f", and {others} more of this kind" if others else ""
        raise InputError(
            "time",
            f"{what} in {row} {place + 1 + first}, {time[place + 1]:.9g} s after {time[place]:.9g} s{more}",
            "rising times; sort=True sorts them and keeps the last of several at one time",
        )
    allowed = max(GAP_STEPS * float(np.median(steps)), GAP)
    if largest_gap is not None:
        allowed = _door.positive("largest_gap", largest_gap, allow_inf=True)
    if steps.max() > allowed * (1.0 + 1e-9):
        place = int(np.argmax(steps))
        begins = time[place] - time[0]
        raise InputError(
            "time",
            f"a gap of {steps[place]:.3g} s after {row} {place + first}, {begins:.3g} s from the start",
            f"at most {allowed:.3g} s; largest_gap={steps[place]:.3g} accepts it, and joints then move linearly across",
        )


def _check_finite(samples: Samples, q: FloatArray, arm: Arm) -> None:
    bad = ~np.isfinite(q)
    if bad.any():
        row, joint = (int(index) for index in np.argwhere(bad)[0])
        value = samples.columns[row, joint]
        raise InputError(
            "q", f"{value} for {arm.joint_names[joint]} in {samples.row} {row + samples.first}", "finite positions"
        )


def _check_limits(arm: Arm, time: FloatArray, q: FloatArray) -> None:
    """Raises InputError for positions that are far beyond the limits: mostly a wrong unit."""
    lower, upper = arm.position_limits.T
    beyond = np.maximum(lower - q, q - upper)
    if beyond.max() <= BEYOND:
        return
    row, joint = (int(index) for index in np.argwhere(beyond > BEYOND)[0])
    unit, least, most = arm.joint_units[joint], lower[joint], upper[joint]
    advice = 'is it in degrees (angle="deg")? ' if unit == "rad" and np.abs(q[:, joint]).max() > 2.0 * np.pi else ""
    raise InputError(
        "q",
        f"{arm.joint_names[joint]} at {q[row, joint]:.4g} {unit} after {time[row] - time[0]:.3g} s",
        f"positions in its limits, {least:.4g} … {most:.4g} {unit}; {advice}allow_outside=True accepts it",
    )
