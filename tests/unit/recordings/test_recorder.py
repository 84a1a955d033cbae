"""A loop's own recorder: what it wrote is read by other tools, also after a crash, and the loop is never held."""

import gc
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

import stillreach as sr
from stillreach.bags.chunks import ChunkFile
from tests.refusals import refused
from tests.unit.recordings.looped import FULL, PANDA, POSE, START, TICKS, decoded, in_header


def test_another_reader_finds_what_the_loop_did(recorded):
    folder, did = recorded
    found = decoded(folder / "drive.rosbag2.mcap")
    stamps = [round(1e9 * (100.0 + 0.001 * k)) for k in range(TICKS)]
    q, rates, targets, twists, _, _ = zip(*did, strict=True)
    for topic in ("/joint_states", "/joint_commands", "/tool_pose", "/tool_command", "/tf"):
        assert [stamp for stamp, _, _ in found[topic]] == stamps
        assert [number for _, number, _ in found[topic]] == list(range(TICKS))
    np.testing.assert_array_equal([message.position for _, _, message in found["/joint_states"]], q)
    np.testing.assert_array_equal([message.velocity for _, _, message in found["/joint_commands"]], rates)
    assert found["/joint_states"][5][2].name == list(PANDA.joint_names)
    aimed = [k for k, target in enumerate(targets) if target is not None]
    assert [stamp for stamp, _, _ in found["/target_pose"]] == [stamps[k] for k in aimed]
    for topic, ticks, poses in (
        ("/tool_pose", range(TICKS), PANDA.forward(np.array(q))),
        ("/target_pose", aimed, np.array([targets[k] for k in aimed])),
    ):
        for (_, _, message), tick, T in zip(found[topic], ticks, poses, strict=True):
            assert in_header(message) == stamps[tick]
            at, turn = message.pose.position, message.pose.orientation
            np.testing.assert_allclose([at.x, at.y, at.z], T[:3, 3], atol=1e-14)
            R = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
            np.testing.assert_allclose(R, T[:3, :3], atol=1e-14)
    for (_, _, message), twist in zip(found["/tool_command"], twists, strict=True):
        v, w = message.twist.linear, message.twist.angular
        np.testing.assert_array_equal([v.x, v.y, v.z, w.x, w.y, w.z], twist)
    (moved,) = found["/tf"][123][2].transforms
    assert (moved.header.frame_id, moved.child_frame_id) == ("base", "tool")
    np.testing.assert_allclose(moved.transform.translation.z, PANDA.forward(q[123])[2, 3], atol=1e-14)
    assert found["/robot_description"][0][2].data == PANDA.to_urdf()


def test_health_and_status_are_told_when_they_change(recorded):
    folder, did = recorded
    stories = [(health.tolist(), int(status)) for *_, health, status in did]
    wanted = [0, *(k for k in range(1, TICKS) if stories[k] != stories[k - 1])]
    found = decoded(folder / "drive.rosbag2.mcap")["/diagnostics"]
    assert [number for _, number, _ in found] == wanted
    for stamp, tick, message in found:
        assert in_header(message) == stamp
        *joints, whole = message.status
        assert [joint.message for joint in joints] == [sr.Health(code).name.lower() for code in stories[tick][0]]
        flags = sr.Status(stories[tick][1])
        assert set(whole.message.split(", ")) == {flag.name for flag in sr.Status if flag and flag in flags} or {"OK"}
    assert 300 in wanted


def test_the_folder_is_a_rosbag2_that_humble_plays(recorded):
    folder, _ = recorded
    information = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (information["version"], information["storage_identifier"]) == (8, "mcap")
    assert information["duration"]["nanoseconds"] == 699_000_000
    counts = {
        part["topic_metadata"]["name"]: part["message_count"] for part in information["topics_with_message_count"]
    }
    assert counts["/joint_states"] == TICKS
    assert information["message_count"] == sum(counts.values())
    for part in information["topics_with_message_count"]:
        (quality,) = yaml.safe_load(part["topic_metadata"]["offered_qos_profiles"])
        assert all(isinstance(quality[name], int) for name in ("history", "reliability", "durability"))
        assert part["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
    with AnyReader([folder], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        assert {connection.topic: connection.msgcount for connection in reader.connections} == counts
    assert len(sr.Recording.load(folder, arm=PANDA, topic="/joint_states")) == TICKS


def test_its_time_is_the_time_of_day(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    before = time.time_ns()
    with sr.Recorder(tmp_path / "a.rosbag2", controller) as recorder:
        controller.step(START, np.zeros(6))
        recorder.add(START)
    ((stamp, _, _),) = decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]
    assert before <= stamp <= time.time_ns()


def test_what_an_encoder_cannot_say_is_recorded_too(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    q, rates = START.copy(), np.zeros(7)
    tick = controller.bind(q=q, twist=np.zeros(6), rates=rates)
    with sr.Recorder(tmp_path / "a.rosbag2", controller) as recorder:
        q[2] = np.nan
        assert tick() & sr.Status.INVALID_INPUT
        recorder.add(q)
    found = decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")
    np.testing.assert_array_equal(found["/joint_states"][0][2].position, q)
    assert not {"/tool_pose", "/tf", "/tool_command"} & set(found)  # there was none
    np.testing.assert_array_equal(found["/joint_commands"][0][2].velocity, rates)
    assert "INVALID_INPUT" in found["/diagnostics"][0][2].status[-1].message


class Stuck:
    """A disk that does not answer until it is let go."""

    def __init__(self, bag):
        self.free, self.begun, self._add = threading.Event(), threading.Event(), bag.add
        bag.add = self.add

    def add(self, *values):
        self.begun.set()
        assert self.free.wait(60)
        self._add(*values)


def test_a_tick_that_was_refused_is_not_the_last_one_again(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    with sr.Recorder(tmp_path / "a.rosbag2", controller) as recorder:
        recorder.add(START, time=0.0)  # before any
        controller.step(START, [0.01, 0, 0, 0, 0, 0])
        recorder.add(START, time=0.001)
        with refused("q"):
            controller.step(np.full(7, np.nan), np.zeros(6))
        recorder.add(np.full(7, np.nan), time=0.002)
    found = decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")
    assert [stamp for stamp, _, _ in found["/joint_states"]] == [0, 1_000_000, 2_000_000]
    assert [stamp for stamp, _, _ in found["/joint_commands"]] == [1_000_000]
    assert [stamp for stamp, _, _ in found["/tf"]] == [1_000_000]
    said = [message.status[-1].message for _, _, message in found["/diagnostics"]]
    assert [text == "INVALID_INPUT" for text in said] == [True, False, True]


def test_a_rail_is_recorded_in_metres(tmp_path):
    rail = sr.Arm([sr.Joint(name="rail", kind="prismatic"), sr.Joint(name="turn", axis=(1, 0, 0))], tool=np.eye(4))
    controller = sr.Controller(rail, period=0.01)
    with sr.Recorder(tmp_path / "a.rosbag2", controller) as recorder:
        for k in range(5):
            controller.step([0.1 * k, 0.2], np.zeros(6))
            recorder.add([0.1 * k, 0.2], time=0.01 * k)
    recording = sr.Recording.load(tmp_path / "a.rosbag2", arm=rail, topic="/joint_states")
    np.testing.assert_array_equal(recording.q, [[0.1 * k, 0.2] for k in range(5)])


def test_it_knows_its_folder_wherever_the_program_goes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    recorder = sr.Recorder("a.rosbag2", sr.Controller(PANDA))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    recorder.close()
    assert (tmp_path / "a.rosbag2" / "metadata.yaml").is_file()


def test_an_interrupted_close_can_be_called_again(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    controller.step(START, np.zeros(6))
    recorder = sr.Recorder(tmp_path / "a.rosbag2", controller)
    recorder.add(START, time=0.0)
    join = recorder._thread.join
    recorder._thread.join = mock.Mock(side_effect=KeyboardInterrupt)
    with pytest.raises(KeyboardInterrupt):
        recorder.close()
    recorder._thread.join = join
    recorder.close()
    assert len(decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]) == 1


def test_a_forked_process_does_not_write(tmp_path):
    script = (
        "import numpy as np, os, sys, stillreach as sr\n"
        "controller = sr.Controller(sr.arms.panda())\n"
        "controller.step(np.ones(7), np.zeros(6))\n"
        "with sr.Recorder(sys.argv[1], controller) as recorder:\n"
        "    recorder.add(np.ones(7))\n"
        "    if (child := os.fork()) == 0:\n"
        "        ok = not recorder.add(np.ones(7)) and recorder.dropped == 1\n"
        "        recorder.close()\n"
        "        os._exit(0 if ok else 1)\n"
        "    assert os.waitpid(child, 0)[1] == 0\n"
    )
    subprocess.run([sys.executable, "-c", script, tmp_path / "a.rosbag2"], check=True)
    assert len(decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]) == 1


def test_a_disk_that_stalls_costs_ticks_and_not_time(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    controller.step(START, np.zeros(6))
    recorder = sr.Recorder(tmp_path / "a.rosbag2", controller, seconds=0.5)
    disk = Stuck(recorder._bag)
    recorder.add(START, time=0.0)
    assert disk.begun.wait(60)  # the thread has taken that tick
    kept = [recorder.add(START, time=0.001 * k) for k in range(1, 801)]
    assert kept == [True] * 500 + [False] * 300
    assert recorder.dropped == 300
    disk.free.set()
    with pytest.warns(RuntimeWarning, match="300 of 801 ticks"):
        recorder.close()
    stamps = [stamp for stamp, _, _ in decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]]
    assert stamps == [1_000_000 * k for k in range(501)]


def test_a_full_disk_is_told_at_the_end(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    controller.step(START, np.zeros(6))
    recorder = sr.Recorder(tmp_path / "a.rosbag2", controller, seconds=0.2)

    def full(*values):
        raise OSError(28, "No space left on device")

    recorder._bag.add = full
    recorder.add(START)
    recorder._thread.join(60)
    assert not recorder.add(START)  # nothing is written any more
    assert "No space left" in repr(recorder)
    with pytest.raises(OSError, match=r"No space left.*after 0 ticks.*--recover.*a.rosbag2"):
        recorder.close()
    recorder.close()


def test_bad_input_is_refused_and_records_nothing(tmp_path):
    controller = sr.Controller(PANDA, period=0.001)
    with refused("controller", "a Controller"):
        sr.Recorder(tmp_path / "a.rosbag2", PANDA)
    with refused("seconds", "1 GB"):
        sr.Recorder(tmp_path / "a.rosbag2", controller, seconds=1e6)
    with pytest.raises(OSError, match="too long"):
        sr.Recorder(tmp_path / ("a" * 252), controller)
    with refused("seconds", "0"):
        sr.Recorder(tmp_path / "a.rosbag2", controller, seconds=0.0)
    with refused("path", "a new folder"):
        sr.Recorder("", controller)
    with refused("path", "which exists"):
        sr.Recorder(tmp_path, controller)
    assert list(tmp_path.iterdir()) == []
    with sr.Recorder(tmp_path / "a.rosbag2", controller) as recorder:
        controller.step(START, np.zeros(6))
        with refused("q", "3", "7"):
            recorder.add(np.zeros(3))
        with refused("target", "(3, 3)"):
            recorder.add(START, np.eye(3))
        with refused("target"):
            recorder.add(START, np.zeros((4, 4)))
        for moment in (-1.0, np.inf, 1e12):
            with refused("time"):
                recorder.add(START, time=moment)
        recorder.add(dict(zip(PANDA.joint_names, START, strict=True)))
    assert recorder.written == 1
    assert not recorder.add(START)  # it is closed
    with refused("q"):
        recorder.add("x")


def test_a_recorder_that_nobody_closed_is_closed_at_the_end(tmp_path):
    script = (
        "import numpy as np, sys, stillreach as sr\n"
        "controller = sr.Controller(sr.arms.panda())\n"
        "recorder = sr.Recorder(sys.argv[1], controller)\n"
        "controller.step(np.ones(7), np.zeros(6)); recorder.add(np.ones(7))\n"
    )
    subprocess.run([sys.executable, "-c", script, tmp_path / "a.rosbag2"], check=True)
    assert len(decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]) == 1


def resident():
    """[bytes] of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads /proc/self/statm")
@pytest.mark.timeout(900)
def test_a_long_recording_does_not_grow_in_memory(tmp_path, monkeypatch):
    """An hour's ticks at 1 kHz with STILLREACH_FULL=1, five minutes' without; what is written is thrown away."""

    def nowhere(file, *parts):
        file._at += sum(map(len, parts))

    monkeypatch.setattr(ChunkFile, "_put", nowhere)
    monkeypatch.setattr(threading, "Thread", mock.Mock())  # its work is done here, so that no tick is dropped
    controller = sr.Controller(PANDA, period=0.001)
    controller.step(START, np.zeros(6))
    recorder = sr.Recorder(tmp_path / "a.rosbag2", controller, seconds=5.0)
    rows, ticks, used = np.empty((128, recorder._width)), 3_600_000 if FULL else 300_000, []
    for part in range(10):
        for k in range(ticks // 10):
            recorder.add(START, POSE, 0.001 * (part * ticks // 10 + k))
            if k % 2000 == 0:
                recorder._drain(rows)
        gc.collect()
        used.append(resident())
    assert recorder.dropped == 0 < recorder.written
    assert used[-1] - used[1] < 2**20
