"""How the paper was read: its equations, what it leaves open, and what was inferred."""

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
The joint sequence is printed RPR-PR-PR-PR-RPR, which has twelve letters, for an arm of 11 joints; two adjacent rolls on
one axis would be one joint. The second start vector has 11 entries, non-zero exactly at joints 2, 4, 6, 8: the arm
alternates R P R P R P R P R P R.

The first start vector has 12 entries; the last zero is dropped: (45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0) deg.

The captions of figures 4 and 5 say "all joints free" where the text says that joints 1, 6, 7 have failed; the text
calls figure 11 joint angles, its caption joint rates; "κ = 0 in (11)" means (6); with no failed joint A is empty and
B = I.

Eq. (9), (10) are said to minimise the deviation. For the ∞-norm they do not: least squares inside the rate limits has
less task error (a row of the claims).

Lengths, run time and step are not given, only the reach of 15 ft. Inferred: six segments of 30 in (base to first pitch,
four between pitches, last pitch to tool), rolls in the middle of their segments, straight up at zero, positive pitch
leaning towards -x, runs of 20 s with steps of 0.05 s.

The command of example 1 is inferred: (-110, -50, 30) in with the attitude kept ends at (3.4, 2.8, 103) in with largest
rates of 10.2 deg/s free and 18.1 deg/s failed. It leads to (3.2, 3.2, 103.4) in; the rest is the Euler step's.

The start of example 2 is inferred from the values of the claims. Of all starts in steps of 5 deg with a command of
-100 in along x or z, those that give the failed arm's values (50 deg/s passed at 2.2 s, -56 in, -37 in, -13 deg) have
the command along x, j2 + j4 + j6 = -10 deg and j8 = 30 deg. Of these the free arm's values (largest rate 5.02 deg/s,
smallest singular value 0.41 in metres and radians) leave (j2, j4, j6) = (-50, -30, 70) and (-50, -50, 90) deg. The
first is taken: rolls tilted by 1e-6 rad lower its least error of a sideways command of 6 m/s by 6e-7, the other's by
8e-7, and 6e-7 is known. (-60, -20, 70) deg fits if that singular value is meant in inches and degrees. While they
stay in the plane, the failed arm's runs are the same from all three.

Which picture is figure 1, 4, 5 and 11 is known. The order of the others is inferred: the free arm before the failed
one, the pseudoinverse before the singularity-robust law, what the joints do before what the tool does.

Example 2 starts in a plane, and so does every motion that the laws of the paper ask for. The failed arm cannot make the
commanded motion in that plane: past 2.2 s its three working pitch joints are stretched out. There the plane is
unstable, rounding errors grow, and runs that differ in the last digit can differ visibly later: the exact damping's
run leaves the plane and nearly finishes, or stays in it and stops halfway, by step and processor. Those values are
shown for several steps, and no claim rests on them. Closed-form damping keeps the arm in the plane.

Attitudes are pitch, yaw, roll with R = R_y(pitch) R_z(yaw) R_x(roll). Damping factors and task errors are in inches and
degrees, those of the run called stillreach in metres and radians.

Example 1 and the free run of example 2 use the singularity-robust law. Its damping is 0 all the way, by eq. (9), so
it is the pseudoinverse of eq. (3) inside the rate limit. The run called pseudoinverse has no rate limit.
"""

READING = tuple(" ".join(note.split("\n")) for note in _READING.strip().split("\n\n"))
"""What needs reading between the lines, a paragraph each."""
