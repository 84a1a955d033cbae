"""Orders of convergence, against an integration that shares nothing with the package: SciPy's."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stillreach as sr
from tests.unit.arm.literal_kinematics import jacobian
from tests.unit.simulation.scenarios import eight_joints, eight_joints_start, waving

DURATION = 1.6
FAILED = 3


def literal_end(pieces):
    """Joint values after all pieces (end, twist of time, failed joints), to 1e-12."""
    arm = eight_joints()
    q, begin = eight_joints_start(), 0.0
    for end, twist, failed in pieces:

        def rates(t, q, twist=twist, failed=failed):
            J = jacobian(arm.joints, arm.tool, q)
            J[:, failed] = 0.0
            return np.linalg.pinv(J) @ np.asarray(twist(t), float)

        q = solve_ivp(rates, (begin, end), q, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        begin = end
    return q


def errors(integrator, steps, motion, pieces, faults=()):
    """Distance from the literal end, for each number of steps."""
    exact = literal_end(pieces)
    ends = []
    for count in steps:
        scenario = sr.Scenario(
            arm=eight_joints(),
            start=eight_joints_start(),
            motion=motion,
            faults=faults,
            law=sr.Pseudoinverse(),
            period=DURATION / count,
            duration=DURATION,
            integrator=integrator,
            transition_rate=0.0,
        )
        ends.append(sr.simulate(scenario).q[-1])
    return np.linalg.norm(np.array(ends) - exact, axis=1)


@pytest.mark.parametrize(("integrator", "order", "steps"), [("euler", 1, (160, 320, 640)), ("rk4", 4, (16, 32, 64))])
def test_the_error_falls_with_the_order_of_the_integrator(integrator, order, steps):
    found = errors(integrator, steps, waving, [(DURATION, waving, [])])
    np.testing.assert_allclose(np.log2(found[:-1] / found[1:]), order, atol=0.15)


def test_runge_kutta_keeps_its_order_across_faults_and_jumps_of_the_command():
    def held(t):
        return (0.1, 0.0, -0.1, 0.2, 0.0, 0.1)

    motion = [sr.ConstantTwist(held(0), 0.4), waving]
    pieces = [(0.4, held, []), (0.8, waving, []), (DURATION, waving, [FAILED])]
    found = errors("rk4", (16, 32, 64), motion, pieces, faults=[sr.Fault(FAILED, at=0.8)])
    np.testing.assert_allclose(np.log2(found[:-1] / found[1:]), 4, atol=0.2)
