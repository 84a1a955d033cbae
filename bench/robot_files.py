"""The arm as peers read it: URDF and MJCF with joints of one number each, the failed ones frozen where they stand."""

from collections.abc import Mapping
from xml.etree import ElementTree as Xml

import numpy as np
from scipy.spatial.transform import Rotation

import stillreach as sr

TOOL = "tool"
FAR = "1000"
"""A position limit that is never met: several readers make a joint without one into a pair (cos, sin)."""


def urdf(arm: sr.Arm, limit: float, frozen: Mapping[int, float] | None = None) -> str:
    """URDF text; `frozen` joints (index: position [rad]) become part of their links."""
    robot = Xml.Element("robot", name="arm")
    parent = _urdf_link(robot, "base_link")
    for index, joint in enumerate(arm.joints):
        held = frozen is not None and index in frozen
        placement = joint.placement @ turned(joint, frozen[index]) if held else joint.placement
        child = _urdf_link(robot, f"{joint.name}_link")
        element = _urdf_joint(robot, str(joint.name), "fixed" if held else "revolute", (parent, child), placement)
        if not held:
            Xml.SubElement(element, "axis", xyz=_text(joint.axis))
            Xml.SubElement(element, "limit", lower=f"-{FAR}", upper=FAR, velocity=repr(float(limit)), effort=FAR)
        parent = child
    _urdf_joint(robot, "tool_mount", "fixed", (parent, _urdf_link(robot, TOOL)), arm.tool)
    return Xml.tostring(robot, encoding="unicode")


def mjcf(arm: sr.Arm, frozen: Mapping[int, float] | None = None) -> str:
    """MJCF text with the tool as a site."""
    robot = Xml.Element("mujoco", model="arm")
    Xml.SubElement(robot, "compiler", angle="radian")
    body = Xml.SubElement(robot, "worldbody")
    for index, joint in enumerate(arm.joints):
        held = frozen is not None and index in frozen
        placement = joint.placement @ turned(joint, frozen[index]) if held else joint.placement
        body = Xml.SubElement(body, "body", name=f"{joint.name}_link", **_mjcf_pose(placement))
        Xml.SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        if not held:
            Xml.SubElement(body, "joint", name=str(joint.name), type="hinge", axis=_text(joint.axis))
    Xml.SubElement(body, "site", name=TOOL, **_mjcf_pose(arm.tool))
    return Xml.tostring(robot, encoding="unicode")


def chain(arm: sr.Arm, frozen: Mapping[int, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Placements (k, 4, 4), axes (k, 3) and tool (4, 4) of the joints that are not frozen."""
    placements, axes, T = [], [], np.eye(4)
    for index, joint in enumerate(arm.joints):
        T = T @ joint.placement
        if index in frozen:
            T = T @ turned(joint, frozen[index])
        else:
            placements.append(T)
            axes.append(joint.axis)
            T = np.eye(4)
    return np.array(placements), np.array(axes), T @ arm.tool


def turned(joint: sr.Joint, position: float) -> np.ndarray:
    """(4, 4) motion of a revolute joint."""
    if joint.kind != "revolute":
        raise ValueError(f"joint {joint.name} is {joint.kind}: only revolute joints can be written")
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(position * joint.axis).as_matrix()
    return T


def _urdf_link(robot: Xml.Element, name: str) -> str:
    inertial = Xml.SubElement(Xml.SubElement(robot, "link", name=name), "inertial")
    Xml.SubElement(inertial, "mass", value="1")
    Xml.SubElement(inertial, "inertia", ixx="1", iyy="1", izz="1", ixy="0", ixz="0", iyz="0")
    return name


def _urdf_joint(robot: Xml.Element, name: str, kind: str, links: tuple[str, str], T: np.ndarray) -> Xml.Element:
    joint = Xml.SubElement(robot, "joint", name=name, type=kind)
    Xml.SubElement(joint, "parent", link=links[0])
    Xml.SubElement(joint, "child", link=links[1])
    rpy = Rotation.from_matrix(T[:3, :3]).as_euler("xyz")
    Xml.SubElement(joint, "origin", xyz=_text(T[:3, 3]), rpy=_text(rpy))
    return joint


def _mjcf_pose(T: np.ndarray) -> dict[str, str]:
    x, y, z, w = Rotation.from_matrix(T[:3, :3]).as_quat()
    return {"pos": _text(T[:3, 3]), "quat": _text((w, x, y, z))}


def _text(values: object) -> str:
    return " ".join(repr(float(value)) for value in np.asarray(values))
