"""What MuJoCo says of the chain between two bodies of a model, whatever the chain's direction."""

import mujoco
import numpy as np


class Peer:
    """A whole MuJoCo model, from text or from a path."""

    def __init__(self, source):
        text = str(source)
        load = mujoco.MjModel.from_xml_string if text.lstrip().startswith("<") else mujoco.MjModel.from_xml_path
        self.model = load(text)
        self.data = mujoco.MjData(self.model)
        joints = range(self.model.njnt)
        self.joints = {self._name(i): i for i in joints}

    def _name(self, joint):
        body = self.model.jnt_bodyid[joint]
        place = joint - self.model.body_jntadr[body] + 1
        return self.model.joint(joint).name or f"{self.model.body(body).name} joint {place}"

    def chain(self, base, tip, names, q):
        """Pose (4, 4) of the tip and Jacobian (6, n) of the named joints, seen from the base."""
        joints = [self.joints[name] for name in names]
        self.data.qpos[:] = self.model.qpos0
        self.data.qpos[self.model.jnt_qposadr[joints]] = q
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        T_base, J_base = self._frame(base)
        T_tip, J_tip = self._frame(tip)
        turned = np.cross(J_base[3:].T, T_tip[:3, 3] - T_base[:3, 3]).T
        J = np.kron(np.eye(2), T_base[:3, :3].T) @ np.vstack([J_tip[:3] - J_base[:3] - turned, J_tip[3:] - J_base[3:]])
        return np.linalg.inv(T_base) @ T_tip, J[:, self.model.jnt_dofadr[joints]]

    def _frame(self, name):
        J, T = np.zeros((6, self.model.nv)), np.eye(4)
        body = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)
        if body >= 0:
            mujoco.mj_jacBody(self.model, self.data, J[:3], J[3:], body)
            T[:3, 3], T[:3, :3] = self.data.xpos[body], self.data.xmat[body].reshape(3, 3)
        else:
            site = self.model.site(name).id
            mujoco.mj_jacSite(self.model, self.data, J[:3], J[3:], site)
            T[:3, 3], T[:3, :3] = self.data.site_xpos[site], self.data.site_xmat[site].reshape(3, 3)
        return T, J
