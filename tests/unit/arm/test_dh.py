"""Denavit-Hartenberg rows, both conventions, against the product of the four transforms and known robots."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.arm import DHRow
from tests.unit.arm.literal_kinematics import rotation

PI = np.pi
PUMA_560 = [  # standard; Corke's frame conventions, metres
    DHRow(alpha=PI / 2),
    DHRow(a=0.4318),
    DHRow(d=0.15005, a=0.0203, alpha=-PI / 2),
    DHRow(d=0.4318, alpha=PI / 2),
    DHRow(alpha=-PI / 2),
    DHRow(),
]
PANDA = [  # modified; the maker's table, metres
    DHRow(d=0.333),
    DHRow(alpha=-PI / 2),
    DHRow(d=0.316, alpha=PI / 2),
    DHRow(a=0.0825, alpha=PI / 2),
    DHRow(a=-0.0825, d=0.384, alpha=-PI / 2),
    DHRow(alpha=PI / 2),
    DHRow(a=0.088, alpha=PI / 2),
]
ODD = [  # both kinds, an offset in every column
    DHRow(a=0.1, alpha=0.3, d=-0.2, theta=0.5),
    DHRow(a=-0.3, alpha=-1.2, d=0.4, theta=-0.7, kind="prismatic"),
    DHRow(a=0.2, alpha=2.0, d=0.1, theta=3.0),
    DHRow(a=0.0, alpha=-0.4, d=0.6, theta=1.1, kind="prismatic"),
]


def turn(axis, angle):
    T = np.eye(4)
    T[:3, :3] = rotation(np.array(axis, float), angle)
    return T


def shift(x, y, z):
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def literal_row(row, value, convention):
    """The four transforms of a row, one after the other."""
    theta = row.theta + (value if row.kind == "revolute" else 0.0)
    d = row.d + (value if row.kind == "prismatic" else 0.0)
    along = [turn((0, 0, 1), theta), shift(0, 0, d)]
    across = [shift(row.a, 0, 0), turn((1, 0, 0), row.alpha)]
    steps = along + across if convention == "standard" else across[::-1] + along
    return np.linalg.multi_dot(steps)


def printed_row(row, angle, convention):
    """The matrix that textbooks print (standard: Spong, modified: Craig eq. 3.6), for a revolute row."""
    c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(row.alpha), np.sin(row.alpha)
    if convention == "standard":
        rows = [[c, -s * ca, s * sa, row.a * c], [s, c * ca, -c * sa, row.a * s], [0, sa, ca, row.d]]
    else:
        rows = [[c, -s, 0, row.a], [s * ca, c * ca, -sa, -sa * row.d], [s * sa, c * sa, ca, ca * row.d]]
    return np.array([*rows, [0, 0, 0, 1]])


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("rows", [PUMA_560, PANDA, ODD, ODD[::-1], ODD[1:2]])
def test_pose_is_the_product_of_the_rows(rows, convention):
    arm = sr.Arm.from_dh(rows, convention)
    for q in np.random.default_rng(5).uniform(-4, 4, (20, len(rows))):
        T = np.eye(4)
        for row, value in zip(rows, q, strict=True):
            T = T @ literal_row(row, value, convention)
        np.testing.assert_allclose(arm.forward(q), T, rtol=0, atol=1e-13)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_a_row_is_the_matrix_that_textbooks_print(convention):
    for row in PUMA_560 + PANDA + ODD[::2]:
        for value in (0.0, 0.4, -2.5):
            T = sr.Arm.from_dh([row], convention).forward([value])
            np.testing.assert_allclose(T, printed_row(row, row.theta + value, convention), rtol=0, atol=1e-14)


def test_puma_560_at_zero_is_where_it_is_known_to_be():
    T = sr.Arm.from_dh(PUMA_560).forward(np.zeros(6))
    np.testing.assert_allclose(T[:3, 3], [0.4318 + 0.0203, -0.15005, 0.4318], rtol=0, atol=1e-15)
    np.testing.assert_allclose(T[:3, :3], np.eye(3), rtol=0, atol=1e-15)


def test_panda_flange_at_zero_points_down_where_it_is_known_to_be():
    arm = sr.Arm.from_dh(PANDA, "modified", tool=shift(0, 0, 0.107))
    T = arm.forward(np.zeros(7))
    np.testing.assert_allclose(T[:3, 3], [0.088, 0, 0.333 + 0.316 + 0.384 - 0.107], rtol=0, atol=1e-15)
    np.testing.assert_allclose(T[:3, :3], np.diag([1, -1, -1]), rtol=0, atol=1e-15)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_base_comes_before_the_table_and_tool_after_it(convention):
    base, tool = shift(1, 2, 3) @ turn((0, 1, 0), 0.8), turn((1, 0, 0), -0.5) @ shift(0.1, 0, 0.2)
    plain = sr.Arm.from_dh(ODD, convention)
    placed = sr.Arm.from_dh(ODD, convention, base=base, tool=tool, name="placed")
    q = [0.3, -0.2, 1.5, 0.7]
    np.testing.assert_allclose(placed.forward(q), base @ plain.forward(q) @ tool, rtol=0, atol=1e-14)
    assert placed.name == "placed"


def test_names_kinds_and_limits_reach_the_arm():
    rows = [DHRow(name="lift", kind="prismatic"), DHRow(a=1.0)]
    arm = sr.Arm.from_dh(rows, velocity_limits=[0.1, 2.0])
    assert arm.joint_names == ("lift", "j2")
    assert arm.kinds.tolist() == [1, 0]
    assert arm.velocity_limits.tolist() == [0.1, 2.0]


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ([], "none"),
        ([(0.1, 0.2, 0.3, 0.4)], "(0.1, 0.2, 0.3, 0.4) of shape (4,) at place 0"),
        ([DHRow(), None], "None at place 1"),
        (3, "3"),
    ],
)
def test_rows_of_numbers_are_refused(rows, told):
    with pytest.raises(sr.InputError, match=r"rows") as caught:
        sr.Arm.from_dh(rows)
    assert caught.value.got == told
    assert "DHRow" in caught.value.expected


def test_another_convention_is_refused_with_a_hint():
    with pytest.raises(sr.InputError, match=r"convention: got 'Modifed'.*did you mean 'modified'"):
        sr.Arm.from_dh(PANDA, "Modifed")


@pytest.mark.parametrize("field", ["a", "alpha", "d", "theta"])
@pytest.mark.parametrize("value", [np.nan, np.inf, True, "1", None, [1.0], 1j])
def test_a_row_holds_finite_numbers(field, value):
    with pytest.raises(sr.InputError, match=f"^{field}: got .*, expected a finite number"):
        DHRow(**{field: value})


def test_a_row_of_another_kind_is_refused():
    with pytest.raises(sr.InputError, match=r"kind: got 'screw', expected one of 'revolute', 'prismatic'"):
        DHRow(kind="screw")


@pytest.mark.parametrize("argument", ["base", "tool"])
def test_a_base_or_tool_that_is_not_rigid_is_refused(argument):
    with pytest.raises(sr.InputError, match=f"^{argument}: "):
        sr.Arm.from_dh(PANDA, **{argument: 2 * np.eye(4)})
