import matplotlib.pyplot as plt
import numpy as np
import pytest

import stillreach as sr
from stillreach.show import arm3d
from tests.unit.arm.odd_arms import ODD_ARMS, configurations


@pytest.fixture(params=ODD_ARMS)
def arm(request):
    return ODD_ARMS[request.param]()


def test_any_arm_can_be_drawn_and_fits_into_its_axes(arm):
    figure = plt.figure()
    ax = figure.add_subplot(projection="3d")
    q = configurations(arm.n)[9]
    arm3d.draw(ax, arm, q, failed=[0])
    figure.canvas.draw()
    points = np.concatenate([shape.ends for shape in arm.shapes(q)])
    for limits, values in zip((ax.get_xlim(), ax.get_ylim(), ax.get_zlim()), points.T, strict=True):
        assert limits[0] < values.min()
        assert values.max() < limits[1]
    drawn = [text.get_text().strip() for text in ax.texts]
    assert set(arm.joint_names) <= set(drawn)


def test_an_arm_draws_itself(arm):
    figure = arm.plot(configurations(arm.n)[9], failed=[arm.joint_names[0]])
    named = ", ".join(text.get_text().strip() for text in figure.axes[0].texts)
    assert sorted(named.split(", ")) == sorted(arm.joint_names)


def test_a_joint_that_is_not_there_cannot_be_drawn_as_failed(arm):
    with pytest.raises(sr.errors.UnknownJointError):
        arm.plot(configurations(arm.n)[0], failed=["nobody"])
