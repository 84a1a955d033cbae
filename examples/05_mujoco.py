"""MuJoCo moves an arm by its servos, a law says how fast; a brake falls. Needs: pip install 'stillreach[mujoco]'"""

import mujoco
import numpy as np

import stillreach as sr

LINKS = ["0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1"]  # roll and pitch in turn
LENGTH = 0.25  # [m] of each link
BODY = """<body name="link{k}" pos="0 0 {z}" gravcomp="1"><joint name="j{k}" axis="{axis}" damping="1" armature="0.1"/>
<geom type="capsule" fromto="0 0 0 0 0 {length}" size="0.04" mass="1.5" contype="0" conaffinity="0"/>{inner}</body>"""

tree = f'<site name="tool" pos="0 0 {LENGTH}"/>'
for k in range(len(LINKS), 0, -1):
    tree = BODY.format(k=k, z=LENGTH if k > 1 else 0.1, axis=LINKS[k - 1], length=LENGTH, inner=tree)
servos = "".join(f'<velocity joint="j{k}" kv="400" ctrlrange="-1.5 1.5"/>' for k in range(1, len(LINKS) + 1))
model = mujoco.MjModel.from_xml_string(
    f'<mujoco><option timestep="0.002" integrator="implicitfast"/><worldbody>{tree}</worldbody>'
    f'<equality><joint name="brake" joint1="j3" active="false" solref="0.004 1"/></equality>'
    f"<actuator>{servos}</actuator></mujoco>"
)
SITE, BRAKE, JOINT = model.site("tool").id, model.eq("brake").id, model.joint("j3")
SECONDS, ONSET, GAIN = 2.5, 0.5, 8.0  # [s], [s], [1/s]
VELOCITY = np.array([0.06, 0.05, -0.04])  # [m/s] of the tool, whose attitude is to stay


def jacobian(data):
    """Rows [v; w] of the site along the world's axes; a column for each of MuJoCo's velocities (nv, not nq)."""
    J = np.zeros((6, model.nv))
    mujoco.mj_jacSite(model, data, J[:3], J[3:], SITE)
    return J


def follow_line(law):
    """How far off its line the tool ends [m], how far the braked joint has slipped [rad], and MuJoCo's state."""
    data = mujoco.MjData(model)
    data.qpos[:] = [0.3, 0.5, -0.4, 1.1, 0.3, 0.7, 0.2]
    mujoco.mj_forward(model, data)
    begin, attitude = data.site_xpos[SITE].copy(), data.site_xmat[SITE].reshape(3, 3).copy()
    bounds, stood = sr.Bounds.symmetric(model.actuator_ctrlrange[:, 1], n=model.nv), None
    while data.time < SECONDS:
        if stood is None and data.time >= ONSET:  # the brake falls: MuJoCo holds the joint, the law is told
            stood = data.qpos[JOINT.qposadr[0]]
            model.eq_data[BRAKE, 0], data.eq_active[BRAKE] = stood, True
            bounds = bounds.lock([JOINT.dofadr[0]])
        off = begin + VELOCITY * data.time - data.site_xpos[SITE]
        turn, quaternion = np.zeros(3), np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, (attitude @ data.site_xmat[SITE].reshape(3, 3).T).ravel())
        mujoco.mju_quat2Vel(turn, quaternion, 1.0)
        twist = np.concatenate([VELOCITY + GAIN * off, GAIN * turn])
        data.ctrl[:] = law.solve(jacobian(data), twist, bounds).rates
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    off = begin + VELOCITY * data.time - data.site_xpos[SITE]
    return np.linalg.norm(off), abs(data.qpos[JOINT.qposadr[0]] - stood), data


error, moved, data = follow_line(sr.LeastError())
step, J, there = 1e-6, jacobian(data), data.site_xpos[SITE].copy()
data.qpos[1] += step
mujoco.mj_kinematics(model, data)
slope = (data.site_xpos[SITE] - there) / step  # the second column again, by a difference of MuJoCo's positions
print(f"the brake of j3 falls after {ONSET:g} s of {SECONDS:g} s; it lets j3 move by {np.rad2deg(moved):.3f} deg")
print(f"the tool went {100 * np.linalg.norm(VELOCITY) * SECONDS:.1f} cm and is {1e3 * error:.2f} mm off its line")
print(f"a column of the Jacobian against a difference of positions: {np.abs(slope - J[:3, 1]).max():.0e} m")
assert error < 1e-3
assert moved < 1e-2
assert np.abs(slope - J[:3, 1]).max() < 1e-5
