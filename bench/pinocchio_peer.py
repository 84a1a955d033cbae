"""The same work as a competent user of Pinocchio and NumPy writes it: damped least squares on the joints that work."""

import numpy as np
import pinocchio as pin

import stillreach as sr
from bench.workload import FAILED


class PinocchioPeer:
    """Everything that can be prepared is; a tick is one Jacobian, one 6 x 6 solve and two products."""

    def __init__(self, arm: sr.Arm, kappa: float = 1e-12) -> None:
        self.model = pin.Model()
        parent = 0
        for joint in arm.joints:
            kind = pin.JointModelRevoluteUnaligned(*joint.axis)
            parent = self.model.addJoint(parent, kind, pin.SE3(joint.placement), joint.name)
        self.tool = self.model.addFrame(pin.Frame("tool", parent, 0, pin.SE3(arm.tool), pin.FrameType.OP_FRAME))
        self.data = self.model.createData()
        self.working = np.array([i for i, name in enumerate(arm.joint_names) if name not in FAILED])
        self.damping = kappa * np.eye(6)
        self.rates = np.zeros(arm.n)

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Rates (n,) that follow the twist; failed columns removed."""
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = pin.computeFrameJacobian(self.model, self.data, q, self.tool, axes).take(self.working, axis=1)
        self.rates[self.working] = J.T.dot(np.linalg.solve(J.dot(J.T) + self.damping, twist))  # faster than @ here
        return self.rates
