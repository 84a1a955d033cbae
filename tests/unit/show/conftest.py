import pytest
from matplotlib import pyplot


@pytest.fixture(autouse=True)
def _no_figure_stays():
    """Pyplot keeps figures until they are closed."""
    yield
    pyplot.close("all")
