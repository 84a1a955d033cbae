"""Arms that have little in common, and configurations that include the bad places."""

import numpy as np

import stillreach as sr
from tests.unit.arm.literal_kinematics import rotation


def placement(shift, axis=(0.0, 0.0, 1.0), angle=0.0):
    """Shift, then turn (4, 4)."""
    T = np.eye(4)
    T[:3, :3] = rotation(np.asarray(axis) / np.linalg.norm(axis), angle)
    T[:3, 3] = shift
    return T


def random_joints(rng, n, slides=0.3):
    """n joints with skew axes and placements turned any way; about a share `slides` of them prismatic."""
    return [
        sr.Joint(
            kind="prismatic" if rng.random() < slides else "revolute",
            placement=placement(rng.normal(size=3), rng.normal(size=3), rng.uniform(-np.pi, np.pi)),
            axis=rng.normal(size=3),
        )
        for _ in range(n)
    ]


def skew():
    """Seven skew revolute axes and a tool off to the side."""
    rng = np.random.default_rng(7)
    return sr.Arm(random_joints(rng, 7, slides=0.0), tool=placement((0.1, -0.2, 0.3), (1, 2, 3), 1.0), name="skew")


def slides_and_turns():
    """A gantry of three slides that carries a wrist."""
    axes = np.eye(3)
    slides = [sr.Joint(kind="prismatic", axis=axis, placement=placement((0, 0, 0.2))) for axis in axes]
    wrist = [sr.Joint(axis=axis, placement=placement((0.05, 0, 0))) for axis in axes[[2, 1, 0]]]
    return sr.Arm(slides + wrist, tool=placement((0, 0, 0.3)), name="gantry")


def mounted():
    """A fixed placement far from the base and upside down comes first; then turn, slide, turn."""
    first = placement((3.0, -2.0, 1.0), (1.0, 0.0, 0.0), np.pi)
    link = placement((0.4, 0.0, 0.1), (0.0, 1.0, 0.0), 0.3)
    kinds = ["revolute", "prismatic", "revolute", "revolute"]
    joints = [sr.Joint(kind=kind, placement=first if i == 0 else link, axis=(1, 1, i)) for i, kind in enumerate(kinds)]
    return sr.Arm(joints, tool=link, name="mounted")


def forty():
    """Forty skew joints of both kinds."""
    return sr.Arm(random_joints(np.random.default_rng(40), 40), tool=placement((0.1, 0, 0)), name="forty")


def upside_down():
    """Axes along -z and a hair beside -z and +z."""
    axes = [(0, 0, -1), (1e-9, 0, -1), (0, -1e-7, -1), (1e-8, 1e-8, 1), (1e-3, 0, -1)]
    return sr.Arm([sr.Joint(axis=axis, placement=placement((0.3, 0.1, 0.2))) for axis in axes], name="upside down")


def one_slide():
    return sr.Arm([sr.Joint(kind="prismatic", axis=(0, -2, 0))], name="one slide")


def uneven():
    """The paper's arm with segments of other lengths, one of them 0."""
    return sr.arms.nasa_modular(lengths=[0.0, 1.0, 0.2, 0.3, 0.4, 0.5])


ODD_ARMS = {
    "paper": sr.arms.nasa_modular,
    "uneven": uneven,
    "planar1": lambda: sr.arms.planar(1),
    "planar5": lambda: sr.arms.planar(5),
    "snake9": lambda: sr.arms.snake(9),
    "canadarm2": sr.arms.canadarm2,
    "skew": skew,
    "slides and turns": slides_and_turns,
    "mounted": mounted,
    "forty": forty,
    "upside down": upside_down,
    "one slide": one_slide,
}
"""Every arm that the kinematics is tested on, by name."""


def configurations(n, seed=0):
    """(15, n) [rad] or [m]: zero, almost zero, half turns, quarter turns, large values, random ones."""
    rng = np.random.default_rng(seed)
    signs = np.where(np.arange(n) % 2 == 0, 1.0, -1.0)
    special = [np.zeros(n), 1e-7 * signs, np.full(n, np.pi), -np.pi * signs, np.pi / 2 * signs, 1e3 * signs]
    return np.array([*special, 1e3 * rng.uniform(-1, 1, n), *rng.uniform(-np.pi, np.pi, (8, n))])


def scale(arm, q):
    """Size of the numbers involved [m]: links and slides, at least 1."""
    links = sum(np.linalg.norm(joint.placement[:3, 3]) for joint in arm.joints) + np.linalg.norm(arm.tool[:3, 3])
    return 1.0 + links + np.sum(np.abs(q[arm.kinds == 1]))
