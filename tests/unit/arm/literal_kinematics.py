"""Kinematics as the textbook writes it, one 4 x 4 matrix a step; no code of the arm's, only its joints' data."""

import numpy as np


def cross_matrix(k):
    return np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])


def rotation(axis, angle):
    """Rodrigues' formula (3, 3) for a unit axis (3,) and an angle [rad]."""
    K = cross_matrix(axis)
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)


def motion(joint, value):
    """What a joint does at a value: turns about its axis, or slides along it (4, 4)."""
    T = np.eye(4)
    if joint.kind == "revolute":
        T[:3, :3] = rotation(joint.axis, value)
    else:
        T[:3, 3] = value * joint.axis
    return T


def forward(joints, tool, q):
    """Pose of the tool (4, 4): placement, motion, placement, motion, …, tool."""
    T = np.eye(4)
    for joint, value in zip(joints, q, strict=True):
        T = T @ joint.placement @ motion(joint, value)
    return T @ tool


def jacobian(joints, tool, q):
    """Geometric Jacobian (6, n): axis x (tool - joint) over axis if revolute, axis over zero if prismatic."""
    end = forward(joints, tool, q)[:3, 3]
    columns = []
    for i, joint in enumerate(joints):
        frame = forward(joints[:i], joint.placement, q[:i])
        axis = frame[:3, :3] @ joint.axis
        if joint.kind == "revolute":
            columns.append(np.concatenate((np.cross(axis, end - frame[:3, 3]), axis)))
        else:
            columns.append(np.concatenate((axis, np.zeros(3))))
    return np.array(columns).T


def small_rotation_vector(R):
    """Rotation vector (3,) of a rotation by much less than pi: the logarithm of R, without its axis."""
    vector = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2  # axis times sine
    sine = np.linalg.norm(vector)
    return vector if sine == 0 else vector * (np.arcsin(sine) / sine)
