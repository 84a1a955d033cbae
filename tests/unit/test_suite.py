"""What the tests themselves stand on."""

import pytest


@pytest.mark.xdist_group("together")
def test_groups_run_in_one_process(request):
    """A pytest that pytest-xdist does not fit spreads the groups over all processes, and says nothing."""
    started = " ".join(getattr(request.config, "workerinput", {}).get("mainargv", []))
    if "loadgroup" not in started:
        pytest.skip("tests are in groups with --dist loadgroup alone")
    assert request.node.nodeid.endswith("@together")
