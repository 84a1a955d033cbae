"""The paper's arm in NumPy: six equal segments, joints R P R P R P R P R P R, straight up at zero."""

import numpy as np

INCH = 0.0254


def roll(angle):
    """Rotation about z, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def lean(angle):
    """Rotation about -y, (3, 3): z turns towards -x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def paper_arm(q, segment=30 * INCH):
    """Tool position (3,), attitude (3, 3) and Jacobian (6, 11) at `q` (11,) [rad]; `segment` [m].

    Rolls (j1, j3, ...) turn about the link, in the middle of their segment; pitches (j2, j4, ...) lean towards -x.
    """
    rotation, tool = np.eye(3), np.zeros(3)
    origins, axes = np.empty((11, 3)), np.empty((11, 3))
    for i, angle in enumerate(q):
        tool = tool + rotation[:, 2] * segment / 2
        origins[i] = tool
        axes[i] = rotation[:, 2] if i % 2 == 0 else -rotation[:, 1]
        rotation = rotation @ (roll(angle) if i % 2 == 0 else lean(angle))
    tool = tool + rotation[:, 2] * segment / 2
    return tool, rotation, np.vstack((np.cross(axes, tool - origins).T, axes.T))


def planar_arm(q):
    """Tool position (2,) and Jacobian (2, n) of a planar chain of unit links at relative angles `q` (n,) [rad]."""
    heading = np.cumsum(q)
    links = np.stack((np.cos(heading), np.sin(heading)))
    from_joint = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]  # tool seen from each joint
    return np.sum(links, axis=1), np.stack((-from_joint[1], from_joint[0]))
