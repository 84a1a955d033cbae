"""The oracles against each other and against problems solved by hand, before anything is judged by them."""

import math

import numpy as np
import pytest

from oracles import box, equations, exact, null_space
from oracles.bounds_table import joint_bounds
from oracles.cases import BOUNDS, law_cases
from oracles.damping import rate_norm, rates_at, smallest_damping
from oracles.kinematics import INCH, paper_arm, planar_arm
from oracles.price import PriceCase, by_damping, certificate, typical_rate
from oracles.weighted import decompose, task_error

RNG = np.random.default_rng(20)
J = RNG.normal(size=(3, 7))
X = RNG.normal(size=3)
FAILED = np.array([0, 1, 0, 0, 1, 0, 0], bool)
A = equations.failed_rows(FAILED)
BOX = np.where(FAILED, 0.0, 1.0)


def spd(n):
    a = RNG.normal(size=(n, n))
    return a @ a.T + np.eye(n)


def test_b_zeroes_the_failed_joints_and_keeps_the_rest():
    np.testing.assert_allclose(equations.b_matrix(A), np.diag(~FAILED))
    np.testing.assert_array_equal(equations.b_matrix(A[:0]), np.eye(7))


def test_eq3_is_the_svd_solution():
    np.testing.assert_allclose(equations.eq3(J, X, A), decompose(J, X, -BOX, BOX).rates(), atol=1e-13)


def test_eq5_eq6_and_eq12_agree():
    for kappa in (1e-6, 0.3, 40.0):
        by_svd = equations.eq12(J, X, A[:0], kappa)
        np.testing.assert_allclose(equations.eq5(J, X, kappa), by_svd, rtol=1e-8)
        np.testing.assert_allclose(equations.eq6(J, X, kappa), by_svd, rtol=1e-10)


def test_eq8_is_the_weighted_law_on_the_remaining_joints():
    w1, w2, kappa = spd(3), spd(7), 0.37
    by_svd = decompose(J, X, -BOX, BOX, task=w1, joints=w2).rates(kappa)
    np.testing.assert_allclose(equations.eq8(J, X, A, w1, kappa * w2), by_svd, atol=1e-12)
    kept = ~FAILED
    np.testing.assert_allclose(
        np.linalg.solve(equations.eq7(J[:, kept], w1, kappa * w2[np.ix_(kept, kept)]), J[:, kept].T @ w1 @ X),
        by_svd[kept],
        atol=1e-12,
    )


def test_units_weigh_like_diagonal_weights():
    rows, columns = np.array([0.5, 2.0, 3.0]), np.array([1.0, 4.0, 0.3, 1.0, 1.0, 2.0, 1.0])
    by_units = decompose(J, X, -BOX, BOX, row_units=rows, joint_units=columns).rates(0.2)
    by_weights = decompose(J, X, -BOX, BOX, task=rows**-2, joints=columns**-2).rates(0.2)
    np.testing.assert_allclose(by_units, by_weights, atol=1e-13)
    assert task_error(J, X, by_units, row_units=rows) == pytest.approx(np.linalg.norm((X - J @ by_units) / rows))


def test_a_runaway_joint_is_compensated_by_the_others():
    lower, upper = -np.ones(7), np.ones(7)
    lower[4] = upper[4] = 0.8
    rates = decompose(J, X, lower, upper).rates()
    assert rates[4] == 0.8
    np.testing.assert_allclose(J @ rates, X, atol=1e-13)


def test_null_rates_are_the_projector_and_nearest_in_the_weight():
    nu, w2 = RNG.normal(size=7), spd(7)
    plain = decompose(J, X, -BOX, BOX).null_rates(nu)
    np.testing.assert_allclose(plain, equations.null_projector(J, A) @ nu, atol=1e-13)
    weighted = decompose(J, X, -BOX, BOX, joints=w2).null_rates(nu)
    np.testing.assert_allclose(J @ weighted, 0, atol=1e-13)
    other = plain - weighted  # another null motion: W2 (nu - weighted) is orthogonal to it
    kept = ~FAILED
    assert other[kept] @ w2[np.ix_(kept, kept)] @ (nu - weighted)[kept] == pytest.approx(0, abs=1e-12)


def test_closed_form_by_hand():
    # One joint, J = (2): V = U = 1, so kappa = (x / (2 limit))^2 and the rate 2x / (4 + kappa) peaks at the limit.
    j, none = np.array([[2.0]]), np.zeros((0, 1))
    assert equations.eq16(j, np.array([3.0]), none, 0.5, "inf") == pytest.approx(9.0)
    assert equations.eq16(j, np.array([3.0]), none, 0.5, "2") == pytest.approx(9.0)
    # Two joints that share a task: V = (1, 1)/sqrt 2; the largest row sum is 1/sqrt 2, the 2-norm 1.
    j, none = np.array([[1.0, 1.0]]), np.zeros((0, 2))
    assert equations.eq16(j, np.array([1.0]), none, 1.0, "inf") == pytest.approx(0.125)
    assert equations.eq16(j, np.array([1.0]), none, 1.0, "2") == pytest.approx(0.25)
    # A failed joint has a zero row.
    failed = equations.failed_rows(np.array([False, True]))
    assert equations.eq16(j, np.array([1.0]), failed, 1.0, "inf") == pytest.approx(0.25)


def non_monotone(limit):
    """The worked example: J = diag(1, 0.01) R(22.5 deg)', twist J (1, 1); c and s2 for `limit`."""
    c, s = np.cos(np.pi / 8), np.sin(np.pi / 8)
    j = np.diag([1.0, 0.01]) @ np.array([[c, -s], [s, c]]).T
    coefficients, s2 = decompose(j, j @ np.ones(2), -np.ones(2), np.ones(2)).coefficients
    return coefficients / limit, s2


def test_exact_damping_by_hand():
    # One joint: 2x / (4 + kappa) = limit, kappa = 2x / limit - 4.
    assert smallest_damping(np.array([[6.0]]), np.array([4.0]), "inf") == pytest.approx(2.0, rel=1e-12)
    assert smallest_damping(np.array([[6.0]]), np.array([4.0]), "inf", 1.6) == 0.0
    assert smallest_damping(np.array([[6.0]]), np.array([4.0]), "2", 0.5) == pytest.approx(8.0, rel=1e-12)
    # 1/(1 + kappa) - 0.9/(0.1 + kappa) is -8 at 0 and -1 where kappa^2 + 1.2 kappa - 0.7 = 0.
    c, s2 = np.array([[1.0, -0.9]]), np.array([1.0, 0.1])
    assert smallest_damping(c, s2, "inf") == pytest.approx(-0.6 + math.sqrt(0.36 + 0.7), rel=1e-12)


def test_exact_damping_jumps_in_the_worked_example():
    c, s2 = non_monotone(1.0)
    largest = rate_norm(np.stack([rates_at(c, s2, kappa) for kappa in np.linspace(0.0, 0.5, 20001)], axis=1), "inf")
    assert largest[0] == pytest.approx(1.0)
    assert largest.max() == pytest.approx(1.197, abs=5e-4)
    assert smallest_damping(*non_monotone(1.0 + 1e-9), "inf") == 0.0
    assert smallest_damping(*non_monotone(1.0 - 1e-9), "inf") == pytest.approx(0.207, abs=5e-4)


@pytest.mark.parametrize("norm", ["inf", "2"])
def test_exact_damping_meets_the_limit_and_nothing_below_does_on_a_grid(norm):
    checked = 0
    for case in law_cases(400, 5):
        problem, limit = case.decomposed, np.max(case.upper)
        c, s2 = problem.coefficients
        kappa = smallest_damping(c / limit if limit else c, s2, norm)
        if kappa == 0.0:
            continue
        checked += 1
        c = c / limit
        assert rate_norm(rates_at(c, s2, kappa), norm) == pytest.approx(1.0, rel=1e-9)
        grid = kappa * np.concatenate((np.geomspace(1e-12, 0.5, 200), np.linspace(0, 1 - 1e-9, 2000)))
        assert np.all(rate_norm(c @ (1 / (s2[:, None] + grid)), norm) > 1.0)
    assert checked > 100


def test_closed_form_is_conservative():
    for case in law_cases(300, 6):
        problem, limit = case.decomposed, np.max(case.upper)
        if not problem.rank or limit == 0.0:
            continue
        for norm in ("inf", "2"):
            a = equations.failed_rows(case.failed)
            kappa = equations.eq16(case.j, case.twist, a, limit, norm)
            assert rate_norm(problem.rates(kappa), norm) <= limit * (1 + 1e-9)


def test_the_papers_arm_starts_where_the_paper_says():
    start = np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0])
    tool, rotation, j = paper_arm(start)
    np.testing.assert_allclose(tool / INCH, (113.2, 53.2, 73.4), atol=0.05)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-14)
    for i in range(11):
        step = np.eye(11)[i] * 1e-6
        ahead, behind = paper_arm(start + step), paper_arm(start - step)
        np.testing.assert_allclose(j[:3, i], (ahead[0] - behind[0]) / 2e-6, atol=1e-8)
        turn = (ahead[1] - behind[1]) / 2e-6 @ rotation.T
        np.testing.assert_allclose(j[3:, i], (turn[2, 1], turn[0, 2], turn[1, 0]), atol=1e-8)


def test_the_straight_arm_has_rank_three():
    assert np.linalg.matrix_rank(paper_arm(np.zeros(11))[2]) == 3


def test_box_solvers_on_the_worked_planar_arm():
    _, j = planar_arm(np.deg2rad([20, 50, -30, 40]))
    x, limits = np.array([1.8, 2.4]), np.array([0.5, 0.5, 1.0, 1.0])
    assert box.largest_scale(j, x, -limits, limits) == (pytest.approx(0.2227372, abs=5e-8), pytest.approx(0, abs=1e-12))
    assert np.min(limits / np.abs(np.linalg.pinv(j) @ x)) == pytest.approx(0.1661468, abs=5e-8)
    for solver in (box.least_error_bvls, box.least_error_daqp):
        rates = solver(j, x, -limits, limits)
        assert box.error(j, x, rates) == pytest.approx(2.3150470, abs=5e-8)
        assert box.excess_error_bound(j, x, -limits, limits, rates) < 1e-9


def test_box_solvers_agree_on_odd_cases():
    sharp = 0
    for case in law_cases(400, 7, bounds=BOUNDS, runaways=0.3, scaled=0.0):
        size, length = np.linalg.norm(case.j) or 1.0, np.linalg.norm(case.twist) or 1.0
        j, x, lower, upper = case.j / size, case.twist / length, case.lower * size / length, case.upper * size / length
        a, b = (solve(j, x, lower, upper) for solve in (box.least_error_bvls, box.least_error_daqp))
        for rates in (a, b):
            assert np.all((lower <= rates) & (rates <= upper))
        if case.decomposed.kind == "regular" and case.decomposed.condition < 100:
            sharp += 1
            assert box.error(j, x, a) == pytest.approx(box.error(j, x, b), abs=1e-9), case.label
            assert box.excess_error_bound(j, x, lower, upper, a) < 1e-7, case.label
    assert sharp > 200


def test_excess_error_bound_sees_a_worse_answer():
    j, x, ones = np.eye(2), np.array([2.0, 0.5]), np.ones(2)
    assert box.excess_error_bound(j, x, -ones, ones, np.array([1.0, 0.5])) == 0.0
    assert box.excess_error_bound(j, x, -ones, ones, np.array([1.0, 0.0])) >= math.hypot(1, 0.5) - 1


def test_nearest_same_motion_by_hand():
    # Two equal joints carry 3 together, the first at most 1: (1, 2). Nearest to (5, 0): (1, 2) still.
    j, upper = np.array([[1.0, 1.0]]), np.array([1.0, 9.0])
    for reference in (np.zeros(2), np.array([5.0, 0.0])):
        found = box.nearest_same_motion(j, np.array([0.5, 2.5]), -upper, upper, reference)
        np.testing.assert_allclose(found, (1.0, 2.0), atol=1e-12)


def test_largest_scale_by_hand():
    j, x = np.array([[1.0, 1.0]]), np.array([4.0])
    lower, upper = -np.ones(2), np.array([0.5, 0.5])
    assert box.largest_scale(j, x, lower, upper) == (pytest.approx(0.25), 0.0)
    assert box.scale_bound(j, x, lower, upper, upper) == pytest.approx(0.25)
    lower[0] = upper[0] = -3.0  # a runaway that the other joint cannot make up for
    assert box.largest_scale(j, x, lower, upper) == (None, 0.0)


def test_exact_largest_scale_by_hand():
    j, x, lower, upper = np.array([[1.0, 1.0]]), np.array([8.0]), np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    assert exact.largest_scale(j, x, lower, upper) == 0.25
    assert exact.largest_scale(j, x, lower, np.array([1.0, np.inf])) == 1.0
    assert exact.largest_scale(j, -x, lower, np.array([1.0, np.inf])) == 0.25
    assert exact.largest_scale(j, x, np.array([-3.0, -1.0]), np.array([-3.0, 1.0])) is None
    assert exact.largest_scale(j, -x, np.array([-3.0, -1.0]), np.array([-3.0, 1.0])) == 0.5
    _, planar = planar_arm(np.deg2rad([20, 50, -30, 40]))
    limits = np.array([0.5, 0.5, 1.0, 1.0])
    assert exact.largest_scale(planar, np.array([1.8, 2.4]), -limits, limits) == pytest.approx(0.2227372, abs=5e-8)


def test_exact_largest_scale_is_the_linear_programs():
    compared = 0
    for case in law_cases(150, 8, bounds=BOUNDS, runaways=0.3, scaled=0.0):
        if case.decomposed.kind != "regular" or case.decomposed.condition > 1e3:
            continue
        problem = case.boxed
        if len(problem.x) > np.sum(~case.failed):
            continue  # rounding of the twist decides whether it is in reach
        best, _ = box.largest_scale(problem.j, problem.x, problem.lower, problem.upper)
        found = exact.largest_scale(problem.j, problem.x, problem.lower, problem.upper)
        assert (found or 0.0) == pytest.approx(best or 0.0, abs=1e-9), case.label
        compared += 1
    assert compared > 40


def test_null_space_by_hand():
    # Planar 3R of unit links at (any, 60, 120 deg): every joint matters equally, r = 1/sqrt 3.
    _, j = planar_arm(np.deg2rad([17, 60, 120]))
    for i in range(3):
        assert null_space.relative_manipulability(j, [i]) == pytest.approx(1 / math.sqrt(3))
    rates = np.linalg.pinv(j) @ np.array([0.3, -0.2])
    jump = null_space.least_jump(j, rates, [1])
    assert np.linalg.norm(jump) == pytest.approx(abs(rates[1]) * math.sqrt(3))
    np.testing.assert_allclose(j @ jump, 0, atol=1e-14)


def test_bounds_table_by_hand():
    tick = {"rate": (-2.0, 3.0), "period": 0.1}
    assert joint_bounds(**tick) == (-2.0, 3.0, False)
    assert joint_bounds(**tick, fault="locked") == (0.0, 0.0, False)
    assert joint_bounds(**tick, fault=("derated", 0.5)) == (-1.0, 1.5, False)
    assert joint_bounds(**tick, fault=("runaway", 7.0)) == (7.0, 7.0, False)
    assert joint_bounds(**tick, position=(-1.0, 1.0), q=0.9) == (-2.0, pytest.approx(1.0), False)
    assert joint_bounds(**tick, position=(-1.0, 1.0), q=1.2) == (-2.0, 0.0, False)
    assert joint_bounds(**tick, last=1.0, acceleration=5.0) == (0.5, 1.5, False)
    assert joint_bounds(**tick, position=(-1.0, 1.0), q=0.92, acceleration=1.0) == (-0.1, 0.1, False)
    assert joint_bounds(**tick, position=(-9.0, 1.0), q=1.0, last=2.0, acceleration=5.0) == (0.0, 0.0, True)


def test_a_runaway_joint_coupled_by_the_weight_shifts_the_least_motion():
    # No task in reach: J = 0. dq' W2 dq with W2 = [[2, 1], [1, 2]] and dq_2 = 1 is least at dq_1 = -1/2.
    j, lower, upper = np.zeros((1, 2)), np.array([-9.0, 1.0]), np.array([9.0, 1.0])
    problem = decompose(j, np.ones(1), lower, upper, joints=np.array([[2.0, 1.0], [1.0, 2.0]]))
    np.testing.assert_allclose(problem.rates(0.3), (-0.5, 1.0))
    # In general the gradient of e' W1 e + kappa dq' W2 dq over the working joints is zero.
    lower, upper = -np.ones(7), np.ones(7)
    lower[4] = upper[4] = 0.8
    w1, w2, units = spd(3), spd(7), np.linspace(0.5, 2.0, 7)
    dq = decompose(J, X, lower, upper, joint_units=units, task=w1, joints=w2).rates(0.37)
    gradient = J.T @ w1 @ (J @ dq - X) + 0.37 * (w2 @ (dq / units)) / units
    np.testing.assert_allclose(np.delete(gradient, 4), 0, atol=1e-12)
    assert dq[4] == 0.8


@pytest.mark.parametrize(("x", "limit"), [(0.3, 9.0), (2.0, 9.0), (2.0, 0.9)])
def test_a_priced_joint_is_what_it_is_by_hand(x, limit):
    """Least Y |x - j r| + (r - 0.2)^2 / 2, r <= limit: the first of r = 0.2 + j Y, no error, and the bound."""
    j, price = 0.5, 2.0
    rate = min(x / j, 0.2 + j * price, limit)
    u = (rate - 0.2) / j if rate == x / j else price
    case = PriceCase(np.array([[j]]), np.array([x]), -np.ones(1), np.full(1, limit), np.full(1, 0.2), "by hand")
    found = certificate(case, [((0,), price)], np.array([rate]), np.array([u]))
    assert found.objective == pytest.approx(price * abs(x - j * rate) + (rate - 0.2) ** 2 / 2, rel=1e-15)
    assert abs(found.gap) <= 64.0 * found.rounding
    worse = certificate(case, [((0,), price)], np.array([rate - 0.1]), np.array([u]))
    assert worse.gap == pytest.approx(worse.objective - found.objective, rel=1e-12)
    np.testing.assert_allclose(by_damping(case, price), [rate], atol=1e-8)


def test_the_second_largest_limit_of_working_joints_counts():
    assert typical_rate([-1.0, -3.0, 0.5, -2.0], [1.0, 0.0, 0.5, 2.0]) == 2.0
    assert typical_rate([-1.0, 0.0], [1.0, 0.0]) == 1.0
    assert typical_rate([-np.inf, -1.0], [np.inf, 9.0]) == 2.0
    assert typical_rate([0.0], [0.0]) == 0.0
