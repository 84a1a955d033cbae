"""Settings for every test: Hypothesis repeats the same cases in every run, and no deadline measures the machine."""

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("repeatable")

DEAR = ("bound_cases", "paper_cases", "reproduction", "build", "counted")
"""Fixtures to be made once only: with several processes (`-n 2 --dist loadgroup`), the tests of each run in one."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Groups the tests that share a dear fixture, and puts them first: they take longest."""
    for item in items:
        for name in DEAR:
            if name in getattr(item, "fixturenames", ()):
                item.add_marker(pytest.mark.xdist_group(name))
    items.sort(key=lambda item: item.get_closest_marker("xdist_group") is None)
