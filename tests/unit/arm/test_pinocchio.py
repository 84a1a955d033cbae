"""Pose and Jacobian against Pinocchio, to 1e-12 of the arm's size."""

import numpy as np
import pinocchio as pin

from tests.unit.arm.odd_arms import configurations, scale


def pinocchio_model(arm):
    """The same chain, built from the joints' data; its last frame is the tool."""
    model = pin.Model()
    parent = 0
    for i, joint in enumerate(arm.joints):
        build = pin.JointModelRevoluteUnaligned if joint.kind == "revolute" else pin.JointModelPrismaticUnaligned
        parent = model.addJoint(parent, build(*joint.axis), pin.SE3(joint.placement), f"joint {i}")
    tool = model.addFrame(pin.Frame("tool", parent, 0, pin.SE3(arm.tool), pin.FrameType.OP_FRAME))
    return model, tool


def test_pose_and_jacobian_agree_with_pinocchio(arm):
    model, tool = pinocchio_model(arm)
    data = model.createData()
    for q in configurations(arm.n, seed=1):
        J = pin.computeFrameJacobian(model, data, q, tool, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        J = J.reshape(6, arm.n)  # one joint: Pinocchio returns a vector
        pin.framesForwardKinematics(model, data, q)
        pose_error = np.max(np.abs(arm.forward(q) - data.oMf[tool].homogeneous))
        jacobian_error = np.max(np.abs(arm.jacobian(q) - J))
        assert pose_error <= 1e-12 * scale(arm, q)
        assert jacobian_error <= 1e-12 * scale(arm, q)
