"""How the paper was read: its equations, what it leaves open, and what was inferred."""

from __future__ import annotations

EQUATIONS = (
    ("(1), (2) → (3)", "dq = B Jᵀ (J B Jᵀ)⁻¹ ẋ with B = I - Aᵀ(AAᵀ)⁻¹A", "`Pseudoinverse`"),
    ("after (1)", "null motion ν with J ν = 0; projector B - BJᵀ(JBJᵀ)⁺JB with failed joints", "`reference` of every law"),
    ("(4) → (5), (6)", "dq = (JᵀJ + κI)⁻¹Jᵀẋ = Jᵀ(JJᵀ + κI)⁻¹ẋ", "`SingularityRobust(damping=κ)`"),
    ("(7) → (8)", "dq = P⁻¹[I - Aᵀ(AP⁻¹Aᵀ)⁻¹AP⁻¹]JᵀW₁ẋ with P = JᵀW₁J + W₂", "the same law with failed joints and full `Weights`"),
    ("(9), (10)", "κ = 0 if the pseudoinverse meets the limit, else the κ with ‖dq(κ)‖ = limit", '`damping="exact"`'),
    ("(12)-(16)", "κ = [‖V‖ ‖Uᵀẋ‖ / (2 dq_max)]², in the ∞- or the 2-norm", '`damping="closed-form"`'),
)
"""Equation of the paper, what it says, where it is in stillreach."""

READING = (
    "The joint sequence is printed RPR-PR-PR-PR-RPR, which has twelve letters, for an arm of 11 joints; two adjacent rolls on "
    "one axis would be one joint. The second start vector has 11 entries, non-zero exactly at joints 2, 4, 6, 8: the arm alternates "
    "R P R P R P R P R P R.",
    "The first start vector has 12 entries; the last zero is dropped: (45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0) deg.",
    'The captions of figures 4 and 5 say "all joints free" where the text says that joints 1, 6, 7 have failed; the text calls '
    'figure 11 joint angles, its caption joint rates; "κ = 0 in (11)" means (6); with no failed joint A is empty and B = I.',
    "Eq. (9), (10) are said to minimise the deviation. For the ∞-norm they do not: least squares inside the rate limits has less "
    "task error (a row of the claims).",
    "Lengths, run time and step are not given, only the reach of 15 ft. Inferred: six segments of 30 in (base to first pitch, four "
    "between pitches, last pitch to tool), rolls in the middle of their segments, straight up at zero, positive pitch leaning "
    "towards -x, runs of 20 s with steps of 0.05 s.",
    "The command of example 1 is inferred: (-110, -50, 30) in with the attitude kept is the one of whole tens of inches that ends at (3.4, 2.8, 103) in "
    "(the commanded end is (3.2, 3.2, 103.4) in, the rest is the Euler step's) with largest rates of 10.2 deg/s free and 18.1 deg/s failed. Turning the tool to another "
    "attitude on the way does not give these rates.",
    "The start of example 2 is inferred, from what is known of it: joints 2, 4, 6, 8 are the non-zero ones, and the numbers of the claims. "
    "Of all starts in steps of 5 deg with a command along x or z, those with the failed arm's numbers (50 deg/s passed at 2.2 s, -56 in, "
    "-37 in, -13 deg) have a command of -100 in along x, j2 + j4 + j6 = -10 deg and j8 = 30 deg. Of these, the free run's numbers (5.02 deg/s, "
    "smallest singular value 0.41 in metres and radians) leave (j2, j4, j6) = (-50, -30, 70) and (-50, -50, 90) deg; the first is taken, because only there "
    "tilting the rolls by 1e-6 rad lowers the error of a sideways command of 6 m/s by 6e-7. "
    "(-60, -20, 70) deg fits if that singular value is meant in inches and degrees. The failed arm's runs in the plane are the same for all three.",
    "Which picture is figure 1, 4, 5 and 11 is known; the order of the others is inferred: for each example the joint angles before the "
    "joint rates, the free arm before the failed one, the pseudoinverse before the singularity-robust law.",
    "Example 2 starts in a plane, and the commanded motion lies in it. The law never leaves the plane unless rounding does: near the singularity the plane is "
    "unstable, so that runs which differ in the last digit can differ visibly after it, most of all the pseudoinverse's. Their values there are shown for several steps.",
    "Attitudes are shown as pitch, yaw, roll with R = R_y(pitch) R_z(yaw) R_x(roll). Damping factors and task errors are in inches and degrees.",
    "Example 1 and the free run of example 2 run under the singularity-robust law: its damping stays 0, so it is the pseudoinverse of eq. (3), inside the rate limit.",
)
"""What needs reading between the lines."""
