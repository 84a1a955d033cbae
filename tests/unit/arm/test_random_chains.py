"""Any chain of joints that Hypothesis thinks of, against the literal product of transforms."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import stillreach as sr
from tests.unit.arm import literal_kinematics as literal
from tests.unit.arm.odd_arms import placement, scale

lengths = st.floats(-10, 10)
vectors = st.tuples(lengths, lengths, lengths)
directions = vectors.filter(lambda v: np.linalg.norm(v) > 1e-3)
angles = st.one_of(st.sampled_from([0.0, np.pi, -np.pi, np.pi / 2]), st.floats(-10, 10))
poses = st.builds(placement, vectors, directions, angles)
joints = st.builds(sr.Joint, kind=st.sampled_from(["revolute", "prismatic"]), placement=poses, axis=directions)
values = st.one_of(angles, st.floats(-1e4, 1e4), st.floats(-1e-6, 1e-6))
chains = st.lists(st.tuples(joints, values), min_size=1, max_size=8)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(chain=chains, tool=poses)
def test_forward_and_jacobian_of_any_chain(chain, tool):
    arm = sr.Arm([joint for joint, _ in chain], tool=tool)
    q = np.array([value for _, value in chain])
    near = 1e-13 * scale(arm, q)
    np.testing.assert_allclose(arm.forward(q), literal.forward(arm.joints, tool, q), rtol=0, atol=near)
    np.testing.assert_allclose(arm.jacobian(q), literal.jacobian(arm.joints, tool, q), rtol=0, atol=near)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(chain=chains, tool=poses)
def test_the_tool_is_within_reach(chain, tool):
    limited = [(joint, value) for joint, value in chain if joint.kind == "revolute"]
    if limited:
        arm = sr.Arm([joint for joint, _ in limited], tool=tool)
        distance = np.linalg.norm(arm.forward([value for _, value in limited])[:3, 3])
        assert distance <= arm.reach * (1 + 1e-12)
