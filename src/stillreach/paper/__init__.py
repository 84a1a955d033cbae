"""The paper's examples, figures and claims, built only from the public API."""

from stillreach.paper.examples import scenarios
from stillreach.paper.reproduce import reproduce

__all__ = ["reproduce", "scenarios"]
