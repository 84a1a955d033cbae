"""What an error says, apart from its words: those stand in tests/golden/messages.txt."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from stillreach.errors import InputError


@contextmanager
def refused(argument: str, *data: str, error: type[InputError] = InputError) -> Iterator[None]:
    """The block raises an error about an argument that shows these names, choices and numbers."""
    with pytest.raises(error) as caught:
        yield
    assert caught.value.argument == argument
    for part in data:
        assert part in f"{caught.value.got} {caught.value.expected}"
