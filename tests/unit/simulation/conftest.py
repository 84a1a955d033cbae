import pytest

import stillreach as sr


@pytest.fixture
def load(tmp_path):
    """Loads a scenario from a text, as from a file."""

    def loaded(text):
        file = tmp_path / "scenario.toml"
        file.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
        return sr.Scenario.load(file)

    return loaded


@pytest.fixture
def mistakes(load):
    """What is wrong with a text, by place."""

    def found(text):
        with pytest.raises(sr.errors.ScenarioFileError) as caught:
            load(text)
        assert str(caught.value)
        return {mistake.place: mistake for mistake in caught.value.mistakes}

    return found
