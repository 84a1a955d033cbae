"""Settings for every test: Hypothesis repeats the same cases in every run, and no deadline measures the machine."""

from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None, print_blob=True)
settings.load_profile("repeatable")
