"""What `stillreach reach` prints."""

import json

import stillreach as sr


def test_the_command(stillreach):
    facts = json.loads(stillreach("reach", "panda", "--samples", "100", "--q", "middle", "--json").out)
    own = sr.tolerance.reach(sr.arms.panda(), sr.arms.panda().position_limits.mean(axis=1), samples=100, tolerance=1e-6)
    assert [joint["still_reached"] for joint in facts["joints"]] == own.shares.tolist()
    printed = " ".join(stillreach("reach", "panda", "--samples", "100", "--q", "middle").out.split())
    assert printed.startswith("100 poses that panda reaches, and one joint locked in the middle of its limits:")
    assert printed.endswith(own.verdict)
