"""Inverse kinematics of poses by others: one file a peer. This list says what is timed, in the order of the tables."""

from bench.peers import Entry

PACKAGE = "bench.poses"
POSES = (
    Entry("ours", "stillreach, `arm.inverse`, all poses in one call", "ours", "Batch", ours=True, package=PACKAGE),
    Entry("ours-single", "stillreach, `arm.inverse`, a call a pose", "ours", ours=True, package=PACKAGE),
    Entry("tracik-5", "TRAC-IK, at most 5 ms a pose", "tracik", "Short", package=PACKAGE),
    Entry("tracik-50", "TRAC-IK, at most 50 ms", "tracik", package=PACKAGE),
    Entry("ssik", "ssik, analytic, first answer", "ssik", package=PACKAGE),
    Entry("ssik-all", "ssik, analytic, all answers of its grid", "ssik", "All", package=PACKAGE),
    Entry("eaik", "EAIK, analytic, last joint at up to 65 values", "eaik", package=PACKAGE),
    Entry("placo", "placo, a loop of one's own", "placo", package=PACKAGE),
    Entry("mink", "mink (daqp), a loop of one's own", "mink", package=PACKAGE),
    Entry("pink", "Pink (daqp), a loop of one's own", "pink", package=PACKAGE),
)
BY_KEY = {entry.key: entry for entry in POSES}
