"""Floating-point operations of a row of a batch, counted in the headers.

An addition, a multiplication, a division and a square root are one each, a multiply-add is two. Changes of sign,
comparisons and choices between numbers are none. What is counted is what every row needs; a search for damping or for
active bounds adds a number that depends on the row, and is counted in the instructions (`python -m bench.stages`).
"""

LANES = 4
"""Numbers in a register: the vector instructions of four rows are as many as the operations of one."""


TURN, COLUMN = 2 * 3 * (1 + 2), 3 + 3 * (1 + 2)
"""Two axes of a frame turned in their plane; a column of the Jacobian, from a joint's place and axis."""


def sines(n: int) -> int:
    """sincos.hpp: reduction by pi/2 (1 + 3 multiply-adds, 1 subtraction), two polynomials of z = r²."""
    reduction = 2 + 1 + 3 * 2
    sine, cosine = 5 * 2 + 1 + 2, 5 * 2 + 1 + 2 + 2
    return n * (reduction + 1 + sine + cosine)


def kinematics(n: int) -> int:
    """lane_kinematics.hpp, revolute joints with no constant angle.

    n times a turn about z, a shift, a turn about x, a lever arm and a cross product; and the tool's turn about z.
    """
    return sines(n) + n * (TURN + 9 * 2 + TURN + COLUMN) + TURN


def kinematics_of_modules(n: int) -> int:
    """What code for the paper's arm alone would do: on the way to a joint it exchanges axes and shifts along one."""
    return sines(n) + n * (TURN + 3 * 2 + COLUMN)


def gram(k: int, m: int = 6) -> int:
    """lane_solve.hpp, gram: lower triangle of J Jᵀ, and κ on its diagonal."""
    return k * m * (m + 1) + m


def factor(m: int = 6) -> int:
    """factor.hpp, factor: L D Lᵀ, L⁻¹, trace(G), trace(G⁻¹) and their product."""
    pairs, triples = m * (m - 1) // 2, m * (m - 1) * (m - 2) // 6
    eliminate = 2 * (triples + pairs) + pairs + m
    invert = 2 * triples + 3 * pairs
    return eliminate + invert + 2 * m + 1


def solve(k: int, m: int = 6) -> int:
    """factor.hpp, solve: L⁻ᵀ D⁻¹ L⁻¹ b, and Jᵀ times that."""
    return 2 * m * (m - 1) + m + 2 * k * m


def checks(k: int, m: int = 6) -> int:
    """Are these numbers: of the twist, the pose and the rates; and are they of an ordinary size."""
    return 2 * m + 2 * 3 + m + 2 * k


def pseudoinverse(n: int, k: int) -> int:
    """A whole row of `Pseudoinverse` with k >= 6 working joints; every other law does this first."""
    return kinematics(n) + gram(k) + factor() + solve(k) + k + checks(k)
