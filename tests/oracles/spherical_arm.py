"""A 7-joint arm with spherical shoulder and wrist in closed form: the KUKA LBR iiwa 14, axes z y z -y z y z.

The elbow's angle follows from the distance of shoulder and wrist, and the rest from where the elbow is on its circle,
the one free parameter. NumPy only.
"""

import numpy as np

SHOULDER = np.array([0.0, 0.0, 0.36])
UPPER, LOWER, TOOL = 0.42, 0.4, 0.126
"""[m] shoulder to elbow, elbow to wrist, wrist to tool."""


def about_y(angle):
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[c, o, s], [o, i, o], [-s, o, c]]), (0, 1), (-2, -1))


def about_z(angle):
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[c, -s, o], [s, c, o], [o, o, i]]), (0, 1), (-2, -1))


def wrist_distance(poses):
    """(N,) [m] from the shoulder to the wrist's centre, which a pose (N, 4, 4) fixes."""
    return np.linalg.norm(poses[:, :3, 3] - TOOL * poses[:, :3, 2] - SHOULDER, axis=1)


def distance_at(elbow):
    """[m] between shoulder and wrist at an elbow angle [rad], by the law of cosines."""
    return np.sqrt(UPPER**2 + LOWER**2 + 2 * UPPER * LOWER * np.cos(elbow))


def all_configurations(pose, count):
    """(8 count, 7) [rad] all branches of a pose (4, 4) at `count` places of the elbow; empty beyond its reach."""
    wrist = pose[:3, 3] - TOOL * pose[:3, 2] - SHOULDER
    cosine = (wrist @ wrist - UPPER**2 - LOWER**2) / (2 * UPPER * LOWER)
    if abs(cosine) > 1.0:
        return np.empty((0, 7))
    found = []
    for elbow in (np.arccos(cosine), -np.arccos(cosine)):
        bend = about_y(-elbow)  # the axis is -y
        along = UPPER * np.array([0.0, 0.0, 1.0]) + LOWER * bend[:, 2]
        turns = about_z(np.linspace(-np.pi, np.pi, count, endpoint=False))
        shoulder = frame(wrist) @ turns @ frame(along).T
        rest = np.swapaxes(shoulder @ bend, -1, -2) @ pose[:3, :3]
        for first in zyz(shoulder):
            for last in zyz(rest):
                found.append(np.column_stack([first, np.full(count, elbow), last]))
    return np.concatenate(found)


def frame(z):
    """A rotation (3, 3) whose third column is along a vector."""
    axis = z / np.linalg.norm(z)
    x = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def zyz(R):
    """Both triples (N, 3) of angles with R = Rz(a) Ry(b) Rz(c)."""
    b = np.arctan2(np.hypot(R[:, 0, 2], R[:, 1, 2]), R[:, 2, 2])
    a, c = np.arctan2(R[:, 1, 2], R[:, 0, 2]), np.arctan2(R[:, 2, 1], -R[:, 2, 0])
    turned = lambda angle: np.where(angle > 0, angle - np.pi, angle + np.pi)  # noqa: E731
    return np.column_stack([a, b, c]), np.column_stack([turned(a), -b, turned(c)])


def violation(poses, lower, upper, count=720):
    """(N,) [rad] by how much the best of a pose's configurations is outside limits (7,); inf beyond the reach."""
    least = np.full(len(poses), np.inf)
    for row, pose in enumerate(poses):
        q = all_configurations(pose, count)
        if len(q):
            least[row] = np.maximum(np.maximum(lower - q, q - upper).max(axis=1), 0.0).min()
    return least


def excluded_poses(count, lower, upper, *, margin=0.1, seed=0):
    """(count, 4, 4) poses within the arm's reach that no place of the elbow brings within the limits.

    Each is outside by `margin` [rad] at all of 720 places of the elbow, half a degree apart.
    """
    random, kept = np.random.default_rng(seed), []
    while sum(map(len, kept)) < count:
        poses = random_poses(random, count, 0.02, UPPER + LOWER - 0.02)
        kept.append(poses[violation(poses, lower, upper) > margin])
    return np.concatenate(kept)[:count]


def random_poses(random, count, nearest, farthest):
    """(count, 4, 4) poses with the wrist at a distance [m] in this range from the shoulder, and any attitude."""
    x, y, z, w = np.moveaxis(random.normal(size=(count, 4)), -1, 0)
    scale = 1.0 / np.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = (part * scale for part in (x, y, z, w))
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, 0] = np.column_stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    poses[:, :3, 1] = np.column_stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    poses[:, :3, 2] = np.cross(poses[:, :3, 0], poses[:, :3, 1])
    way = random.normal(size=(count, 3))
    way *= (random.uniform(nearest, farthest, count) / np.linalg.norm(way, axis=1))[:, None]
    poses[:, :3, 3] = SHOULDER + way + TOOL * poses[:, :3, 2]
    return poses
