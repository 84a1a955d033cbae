"""What the tests of a price share."""

import stillreach as sr


def answer(law, case, **kwargs):
    """The law's answer to a case of oracles.price."""
    return law.solve(case.j, case.x, sr.Bounds(case.lower, case.upper), reference=case.reference, **kwargs)
