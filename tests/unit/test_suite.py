"""What the tests themselves stand on."""

import os

import pytest


@pytest.mark.xdist_group("together")
@pytest.mark.skipif("PYTEST_XDIST_WORKER" not in os.environ, reason="one process runs all tests")
def test_groups_run_in_one_process(request):
    """A pytest that pytest-xdist does not fit spreads the groups over all processes, and says nothing."""
    assert request.node.nodeid.endswith("@together")
