"""How the paper was read: its equations, what it prints, what it leaves open, and what was inferred."""

from __future__ import annotations

EQUATIONS = (
    ("(1), (2) → (3)", "dq = B Jᵀ (J B Jᵀ)⁻¹ ẋ with B = I - Aᵀ(AAᵀ)⁻¹A", "`Pseudoinverse`"),
    (
        "after (1)",
        "null motion ν with J ν = 0; with failed joints B - BJᵀ(JBJᵀ)⁺JB projects it",
        "`reference`, null motions",
    ),
    ("(4) → (5), (6)", "dq = (JᵀJ + κI)⁻¹Jᵀẋ = Jᵀ(JJᵀ + κI)⁻¹ẋ", "`SingularityRobust(damping=κ)`"),
    (
        "(7) → (8)",
        "dq = P⁻¹[I - Aᵀ(AP⁻¹Aᵀ)⁻¹AP⁻¹]JᵀW₁ẋ with P = JᵀW₁J + W₂",
        "the same law with failed joints and full `Weights`",
    ),
    ("(9), (10)", "κ = 0 if the pseudoinverse meets the limit, else the κ with ‖dq(κ)‖ = limit", '`damping="exact"`'),
    ("(12)-(16)", "κ = [‖V‖ ‖Uᵀẋ‖ / (2 dq_max)]², in the ∞- or the 2-norm", '`damping="closed-form"`'),
)
"""Equation of the paper, what it says, where it is in stillreach."""

_READING = """
Section 6 prints the start configurations, the commands, the failed joints and the rate limit of both examples, and
which figure shows what. It does not print link lengths, run time and step; those are inferred.

The joint sequence is printed RPR-PR-PR-PR-RPR, which has twelve letters, for an arm of 11 joints; two adjacent rolls on
one axis would be one joint. The second start configuration has 11 entries, non-zero exactly at joints 2, 4, 6, 8: the
arm alternates R P R P R P R P R P R.

The first start configuration is printed with 12 entries; the last zero is dropped: (45, -60, 0, -45, 0, 45, 90, 45, 0,
0, 0) deg.

The captions of figures 4 and 5 print "all joints free" where the text says that joints 1, 6, 7 have failed: the figures
here follow the text. The caption of figure 11 says joint rates, the text joint angles: both are shown. "κ = 0 in (11)"
means (6); with no failed joint A is empty and B = I.

Inferred from the reach of 15 ft and the results in the text: six segments of 30 in (base to first pitch, four between
pitches, last pitch to tool), rolls in the middle of their segments, straight up at zero, positive pitch leaning towards
-x, runs of 20 s with Euler steps of 0.05 s.

Two statements on the pseudoinverse in example 2 are not reproduced: rates up to 400 deg/s, and a tool that deviates
somewhat. Past the singularity its motion in the plane is unstable, and step size and rounding decide what happens. Of
561 combinations (base segment 10 to 110 in, tool segment 10, 30 or 50 in, the others equal, 17 steps from 0.005 to
0.2 s) none gives both: rates between 300 and 500 deg/s come with more than 25 in off the line, less than 10 in off the
line with more than 4,000 deg/s.

The κ of eq. (9) and (10) is said to minimise the deviation. For the ∞-norm it does not: least squares inside the rate
limits has less task error.

Example 2 starts in a plane, and every motion that the paper's laws command stays in it. The failed arm cannot make the
commanded motion in that plane: past 2.2 s its three working pitch joints are stretched out. The plane is unstable
there: a run with exact damping leaves it and nearly finishes, or stays in it and stops halfway, by step and processor.
Those values are shown for several steps, and no claim depends on them. Closed-form damping keeps the arm in the plane.

The figures show position in inches, and attitude as pitch, yaw, roll in degrees, R = R_y(pitch) R_z(yaw) R_x(roll);
x and pitch are solid, y and yaw dashed, z and roll dotted. Damping factors and task errors are in inches and degrees,
those of the run called stillreach in metres and radians.

Example 1 and the free run of example 2 use the singularity-robust law. Its damping is 0 all the way, by eq. (9), so
it is the pseudoinverse of eq. (3) inside the rate limit. The run called pseudoinverse has no rate limit.
"""

READING = tuple(" ".join(note.split("\n")) for note in _READING.strip().split("\n\n"))
"""What needs reading between the lines, a paragraph each."""
