"""What the paper reports of the pseudoinverse in example 2 fits none of many other arms and steps."""

import numpy as np

import stillreach as sr
from stillreach.paper import examples

INCH = 0.0254
FAILED = [1, 3, 6]


def peak_and_distance(lengths, step):
    """Largest rate [deg/s], and largest distance of the tool from the commanded line along x [in], in 20 s."""
    arm, start = sr.arms.nasa_modular(lengths), np.deg2rad([examples.START_2])
    rollout = sr.rollout_batch(
        arm,
        examples.BASELINE,
        start,
        np.array([-5.0 * INCH, 0, 0, 0, 0, 0]),
        sr.Bounds.unbounded(11).lock(FAILED),
        period=step,
        steps=round(20.0 / step),
        record=("q", "rates"),
    )
    tool = arm.forward(rollout.q[0])[:, :3, 3] / INCH
    off = np.linalg.norm((tool - arm.forward(start)[0, :3, 3] / INCH)[:, 1:], axis=1)
    return np.rad2deg(np.max(np.abs(rollout.rates))), np.max(off)


def test_no_arm_and_step_gives_400_deg_per_second_together_with_a_tool_that_deviates_somewhat():
    """As docs/paper.md says it: 561 combinations; none within a quarter of 400 deg/s is within 10 in of the line."""
    found = [
        peak_and_distance(np.array([base, *[(180.0 - base - tool) / 4] * 4, tool]) * INCH, step)
        for base in range(10, 111, 10)
        for tool in (10.0, 30.0, 50.0)
        for step in np.geomspace(0.005, 0.2, 17)
    ]
    peak, distance = np.array(found).T
    assert len(found) == 561
    assert np.all(peak > 50.0)  # each becomes singular
    assert not np.any((peak >= 300.0) & (peak <= 500.0) & (distance <= 10.0))
