"""What Pinocchio says of the chain between two links of a URDF file, whatever the chain's direction."""

from functools import cached_property

import numpy as np
import pinocchio as pin


class Peer:
    """Pinocchio's model of a whole URDF text.

    Joints that follow others are led here, by the caller's table {follower: (leader, multiplier, offset)}; Pinocchio
    is told their positions, and their columns are added to their leaders'.
    """

    def __init__(self, text, follows=None, held=None):
        self.model = pin.buildModelFromXML(text)
        self.data = self.model.createData()
        self.follows, self.held = follows or {}, held or {}

    @cached_property
    def ids(self):
        return {name: self.model.getJointId(name) for name in self.model.names}

    def chain(self, base, tip, names, q):
        """Pose (4, 4) of the tip and Jacobian (6, n) of the named joints, seen from the base."""
        values = dict(zip(names, q, strict=True)) | self.held
        for follower, (leader, multiplier, offset) in self.follows.items():
            if follower not in self.held:
                values[follower] = multiplier * values.get(leader, 0.0) + offset
        whole = self.neutral()
        for name, value in values.items():
            joint = self.model.joints[self.ids[name]]
            whole[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(value), np.sin(value)] if joint.nq == 2 else value
        (T_base, J_base), (T_tip, J_tip) = (self._frame(link, whole) for link in (base, tip))
        arm = T_tip[:3, 3] - T_base[:3, 3]
        turned = np.cross(J_base[3:].T, arm).T
        J = np.kron(np.eye(2), T_base[:3, :3].T) @ np.vstack([J_tip[:3] - J_base[:3] - turned, J_tip[3:] - J_base[3:]])
        return np.linalg.inv(T_base) @ T_tip, np.stack([self._column(J, name) for name in names], axis=1)

    def neutral(self):
        """Pinocchio's configuration with all joints at 0."""
        return pin.neutral(self.model)

    def pose(self, link, whole):
        """Pose (4, 4) of a link, seen from the root, at a configuration of Pinocchio."""
        return self._frame(link, whole)[0]

    def _frame(self, link, whole):
        frame = self.model.getFrameId(link, pin.FrameType.BODY)
        pin.computeJointJacobians(self.model, self.data, whole)
        pin.updateFramePlacements(self.model, self.data)
        J = pin.getFrameJacobian(self.model, self.data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        return self.data.oMf[frame].homogeneous.copy(), J.reshape(6, -1).copy()

    def _column(self, J, name):
        column = J[:, self.model.joints[self.ids[name]].idx_v].copy()
        for follower, (leader, multiplier, _) in self.follows.items():
            if leader == name and follower not in self.held:
                column += multiplier * J[:, self.model.joints[self.ids[follower]].idx_v]
        return column
