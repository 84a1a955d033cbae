import pytest

from tests.unit.arm.odd_arms import ODD_ARMS


@pytest.fixture(params=ODD_ARMS)
def arm(request):
    """Each of the odd arms in turn."""
    return ODD_ARMS[request.param]()
