"""What a crash or a bad disk left of a recording is made whole again."""

import random
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import stillreach as sr
from tests.commands import run_command
from tests.refusals import refused
from tests.unit.recordings.looped import FULL, PANDA, TICKS, decoded


@pytest.mark.timeout(900)
def test_a_killed_loop_leaves_all_but_its_last_second(tmp_path):
    """100 moments with STILLREACH_FULL=1, 5 without."""
    moments, done = random.Random(1), 0
    for first in range(0, 100 if FULL else 5, 5):
        folders = [tmp_path / f"{first + k}.rosbag2" for k in range(5)]
        loop = [sys.executable, Path(__file__).with_name("loop.py")]
        loops = [subprocess.Popen([*loop, folder], stdout=subprocess.PIPE, text=True) for folder in folders]
        begun = []
        for process in loops:
            assert process.stdout.readline() == "begins\n"
            begun.append(time.time())
        killed = []
        for process, moment in sorted(
            zip(loops, [t + moments.uniform(1.5, 2.5) for t in begun], strict=True), key=lambda p: p[1]
        ):
            time.sleep(max(0.0, moment - time.time()))
            process.kill()
            killed.append((loops.index(process), time.time()))
            process.wait()
            process.stdout.close()
        for place, when in killed:
            whole = tmp_path / f"whole-{first + place}.rosbag2"
            found = sr.Recorder.recover(folders[place], whole)
            assert found.messages > 0
            with AnyReader([whole]) as reader:
                (states,) = [one for one in reader.connections if one.topic == "/joint_states"]
                stamps = [stamp for _, stamp, _ in reader.messages([states])]
            assert 1e-9 * stamps[-1] > when - 1.0
            file = whole / f"{whole.name}.mcap"
            numbers = [number for _, number, _ in decoded(file)["/joint_states"]]
            assert numbers == list(range(len(stamps)))  # nothing is missing before
            done += 1
    assert done == (100 if FULL else 5)


def test_any_beginning_of_a_file_is_recovered_up_to_its_last_whole_chunk(recorded, tmp_path):
    folder, _ = recorded
    whole = (folder / "drive.rosbag2.mcap").read_bytes()
    everything = decoded(folder / "drive.rosbag2.mcap")["/joint_states"]
    cuts = [len(whole) - 1, *random.Random(2).sample(range(len(whole) // 3, len(whole)), 12)]
    counts = []
    for number, cut in enumerate(sorted(cuts)):
        (tmp_path / "cut.mcap").write_bytes(whole[:cut])
        found = sr.Recorder.recover(tmp_path / "cut.mcap", tmp_path / f"{number}.rosbag2")
        again = decoded(tmp_path / f"{number}.rosbag2" / f"{number}.rosbag2.mcap")
        states = again["/joint_states"]
        assert [one[:2] for one in states] == [one[:2] for one in everything[: len(states)]]
        assert found.messages == sum(map(len, again.values()))
        counts.append(len(states))
        assert found.lost < 200_000
    assert counts == sorted(counts)
    assert sr.Recorder.recover(folder, tmp_path / "complete.rosbag2").lost == 0
    assert counts[-1] == TICKS  # only the summary was cut off


def test_a_chunk_that_is_not_what_was_written_is_left_out(recorded, tmp_path):
    folder, _ = recorded
    data = bytearray((folder / "drive.rosbag2.mcap").read_bytes())
    everything = decoded(folder / "drive.rosbag2.mcap")["/joint_states"]
    data[len(data) // 2] ^= 1
    data = data[:-100]
    (tmp_path / "flipped.mcap").write_bytes(data)
    assert sr.Recorder.recover(tmp_path / "flipped.mcap", tmp_path / "a.rosbag2").lost > 1000
    found = decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]
    assert TICKS - 400 < len(found) < TICKS
    assert found[-1][0] == everything[-1][0]
    read = sr.Recording.load(
        tmp_path / "flipped.mcap", arm=PANDA, topic="/joint_states", largest_gap=np.inf
    )  # it has no end, and not the wrong number either
    assert len(read) == len(found)


@pytest.mark.parametrize(
    "tail",
    [
        struct.pack("<BQ", 6, 5) + b"abcde",
        struct.pack("<BQ", 3, 0),
        struct.pack("<BQ", 4, 40) + bytes(40),
        struct.pack("<BQ", 5, 1) + b"\0",
        struct.pack("<BQ", 5, 2**63),
        bytes(1000),
        b"\xff" * 1000,
    ],
)
def test_rubbish_at_the_end_takes_nothing_away(recorded, tmp_path, tail):
    folder, _ = recorded
    whole = (folder / "drive.rosbag2.mcap").read_bytes()
    end = whole.rindex(struct.pack("<BQI", 15, 4, 0))  # of the messages, before the summary
    (tmp_path / "tail.mcap").write_bytes(whole[:end] + tail)
    sr.Recorder.recover(tmp_path / "tail.mcap", tmp_path / "a.rosbag2")
    assert len(decoded(tmp_path / "a.rosbag2" / "a.rosbag2.mcap")["/joint_states"]) == TICKS
    assert len(sr.Recording.load(tmp_path / "tail.mcap", arm=PANDA, topic="/joint_states")) == TICKS


@pytest.mark.parametrize("chunked", [True, False])
def test_broken_bags_of_others_are_recovered(tmp_path, chunked):
    store, topics = get_typestore(Stores.ROS2_HUMBLE), ["/a", "/b"]
    text = store.generate_msgdef("std_msgs/msg/String", ros_version=2)[0].encode()
    written = {topic: [] for topic in topics}
    with (tmp_path / "other.mcap").open("wb") as opened:
        writer = Writer(opened, chunk_size=2000, compression=CompressionType.ZSTD, use_chunking=chunked)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", text)
        channels = {topic: writer.register_channel(topic, "cdr", schema) for topic in topics}
        for k in range(500):
            topic = topics[k % 2]
            data = bytes(store.serialize_cdr(store.types["std_msgs/msg/String"](f"message {k}"), "std_msgs/msg/String"))
            writer.add_message(channels[topic], 1000 * k, data, 1000 * k)
            written[topic].append((1000 * k, f"message {k}"))
        opened.flush()  # and no end: the process was killed
        recovered = sr.Recorder.recover(tmp_path / "other.mcap", tmp_path / "whole.rosbag2")
    assert recovered.messages > 400
    with AnyReader([tmp_path / "whole.rosbag2"]) as reader:
        found = {topic: [] for topic in topics}
        for connection, stamp, data in reader.messages():
            found[connection.topic].append((stamp, reader.deserialize(data, connection.msgtype).data))
    for topic in topics:
        assert found[topic] == written[topic][: len(found[topic])]


def test_what_is_no_bag_is_refused(tmp_path, recorded):
    (tmp_path / "text.mcap").write_text("no bag")
    (tmp_path / "empty.mcap").write_bytes(b"\x89MCAP0\r\n")
    for path in ("text.mcap", "empty.mcap", "nothing.mcap"):
        with refused("path", path):
            sr.Recorder.recover(tmp_path / path, tmp_path / "new.rosbag2")
    (tmp_path / "hollow").mkdir()
    with refused("path", "0 MCAP files"):
        sr.Recorder.recover(tmp_path / "hollow", tmp_path / "new.rosbag2")
    with refused("to", "which exists"):
        sr.Recorder.recover(recorded[0], tmp_path)
    assert not (tmp_path / "new.rosbag2").exists()


def test_the_command_recovers(recorded, tmp_path):
    folder, _ = recorded
    file = folder / "drive.rosbag2.mcap"
    file.write_bytes(file.read_bytes()[:-5000])
    (folder / "metadata.yaml").unlink()
    answer = run_command("convert", "--recover", folder, tmp_path / "whole.rosbag2")
    assert answer.code == 0
    assert "messages in" in answer.out
    assert (tmp_path / "whole.rosbag2" / "metadata.yaml").is_file()
    again = run_command("convert", "--recover", folder, tmp_path / "whole.rosbag2")
    assert again.code != 0
    assert "which exists" in again.err
