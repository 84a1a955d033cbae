import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.literal_kinematics import forward
from tests.unit.arm.odd_arms import ODD_ARMS, configurations


@pytest.fixture(params=ODD_ARMS)
def arm(request):
    return ODD_ARMS[request.param]()


def test_links_and_joints_are_where_the_textbook_puts_them(arm):
    for q in configurations(arm.n)[[1, 4, 9]]:
        frames = [forward(arm.joints[:k], joint.placement, q[:k]) for k, joint in enumerate(arm.joints)]
        points = [np.zeros(3), *(T[:3, 3] for T in frames), forward(arm.joints, arm.tool, q)[:3, 3]]
        shapes = arm.shapes(q)
        assert len(shapes) == 2 * arm.n + 1
        for k, link in enumerate(shapes[: arm.n + 1]):
            assert (link.name, link.joint) == (f"link {k + 1}", None)
            np.testing.assert_allclose(link.ends, points[k : k + 2], atol=1e-9)
        for k, drum in enumerate(shapes[arm.n + 1 :]):
            assert (drum.name, drum.joint) == (arm.joint_names[k], k)
            np.testing.assert_allclose(np.mean(drum.ends, axis=0), points[k + 1], atol=1e-9)
            np.testing.assert_allclose(drum.pose[:3, 2], frames[k][:3, :3] @ arm.joints[k].axis, atol=1e-9)
        for shape in shapes:
            R = shape.pose[:3, :3]
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(R) > 0.0
            assert shape.radius > 0.0


def test_joints_at_one_point_keep_the_number_of_shapes():
    arm = sr.arms.panda()  # three axes meet in its shoulder
    shapes = arm.shapes(np.zeros(arm.n))
    assert len(shapes) == 2 * arm.n + 1
    assert min(shape.length for shape in shapes) == 0.0
    assert all(np.all(np.isfinite(shape.pose)) for shape in shapes)


def test_a_follower_is_drawn_as_its_leader():
    leader, led = (sr.Joint(name=name) for name in ("a", "b"))
    arm = sr.Arm([leader], followers=[sr.Follower(led, leader="a", place=1)])
    assert [shape.joint for shape in arm.shapes([0.3])] == [None, None, None, 0, 0]


def test_a_configuration_of_another_length_is_refused():
    with pytest.raises(sr.errors.InputError):
        sr.arms.panda().shapes([0.0])
