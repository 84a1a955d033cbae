import pytest

import stillreach as sr
from tests.unit.recordings.looped import PANDA, TICKS, looped


@pytest.fixture
def recorded(tmp_path):
    folder = tmp_path / "drive.rosbag2"
    controller = sr.Controller(PANDA, period=0.001)
    with sr.Recorder(folder, controller) as recorder:
        did = looped(recorder, controller)
    assert recorder.written == TICKS
    assert recorder.dropped == 0
    return folder, did
