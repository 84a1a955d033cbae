"""Runs for other tools, read back by other tools."""

import numpy as np
import pandas as pd
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

import stillreach as sr
from stillreach import InputError
from stillreach.plants import KinematicPlant
from stillreach.simulation.record import HEALTHS
from tests.commands import run_command

PANDA = sr.arms.panda()
JOINTS = list(PANDA.joint_names)
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])


@pytest.fixture(scope="module")
def run():
    motion = sr.Line([0.05, 0.1, -0.1], duration=1.0, relative=True)
    faults = [sr.Fault(3, at=0.3, known_after=0.05, until=0.8), sr.Fault(0, at=0.5, kind=sr.Derated(0.5))]
    plant = KinematicPlant(noise=1e-4)
    return sr.simulate(sr.Scenario(arm=PANDA, start=START, motion=motion, faults=faults, plant=plant, loop="closed"))


def check_table(table, run):
    assert len(table) == len(run)
    np.testing.assert_array_equal(table["time [s]"], run.time)
    for k, joint in enumerate(JOINTS):
        np.testing.assert_array_equal(table[f"{joint} [rad]"], run.q[:, k])
        np.testing.assert_array_equal(table[f"{joint}.measured [rad]"], run.measured[:, k])
        np.testing.assert_array_equal(table[f"{joint}.rates [rad/s]"], run.rates[:, k])
        assert list(table[f"{joint}.health"]) == [HEALTHS[int(code)] for code in run.health[:, k]]
    np.testing.assert_array_equal(table["pose.z [m]"], run.pose[:, 2, 3])
    np.testing.assert_array_equal(table["target.x [m]"], run.target[:, 0, 3])
    turns = Rotation.from_quat(table[["pose.qx", "pose.qy", "pose.qz", "pose.qw"]].to_numpy())
    np.testing.assert_allclose(turns.as_matrix(), run.pose[:, :3, :3], atol=1e-14)
    np.testing.assert_array_equal(table["command.wz [rad/s]"], run.command[:, 5])
    np.testing.assert_array_equal(table["status"], run.status)


def test_csv_in_pandas(run, tmp_path):
    run.save(tmp_path / "run.csv")
    check_table(pd.read_csv(tmp_path / "run.csv"), run)


def test_parquet_in_pandas(run, tmp_path):
    run.save(tmp_path / "run.parquet")
    check_table(pd.read_parquet(tmp_path / "run.parquet"), run)


@pytest.mark.parametrize("name", ["run.csv", "run.parquet", "run.rosbag2"])
def test_what_is_written_is_a_recording(run, tmp_path, name):
    run.save(tmp_path / name)
    recording = sr.Recording.load(
        tmp_path / name, arm=PANDA, **({"topic": "/joint_states"} if name == "run.rosbag2" else {})
    )
    np.testing.assert_array_equal(recording.q, run.q)
    np.testing.assert_allclose(recording.time, run.time, rtol=0, atol=1e-9)


def test_a_rosbag_in_another_reader(run, tmp_path):
    run.save(tmp_path / "run.rosbag2")
    (file,) = (tmp_path / "run.rosbag2").glob("*.mcap")
    found = {}
    with file.open("rb") as opened:
        reader = make_reader(opened, decoder_factories=[DecoderFactory()])
        assert {channel.message_encoding for channel in reader.get_summary().channels.values()} == {"cdr"}
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, schema.name, decoded))
    stamps = np.round(run.time * 1e9).astype(int)
    for topic, values in (("/joint_states", run.q), ("/measured_joint_states", run.measured)):
        assert [stamp for stamp, _, _ in found[topic]] == stamps.tolist()
        assert {kind for _, kind, _ in found[topic]} == {"sensor_msgs/msg/JointState"}
        np.testing.assert_array_equal([message.position for _, _, message in found[topic]], values)
        assert list(found[topic][0][2].name) == JOINTS
        last = found[topic][-1][2].header
        assert last.stamp.sec * 10**9 + last.stamp.nanosec == stamps[-1]
    np.testing.assert_array_equal([message.velocity for _, _, message in found["/joint_commands"]], run.rates)
    for topic, poses in (("/tool_pose", run.pose), ("/target_pose", run.target)):
        here = [message.pose for _, _, message in found[topic]]
        np.testing.assert_array_equal([(p.position.x, p.position.y, p.position.z) for p in here], poses[:, :3, 3])
        turns = Rotation.from_quat([(p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w) for p in here])
        np.testing.assert_allclose(turns.as_matrix(), poses[:, :3, :3], atol=1e-14)
    twists = [message.twist for _, _, message in found["/tool_command"]]
    angular = [(t.angular.x, t.angular.y, t.angular.z) for t in twists]
    np.testing.assert_array_equal([(t.linear.x, t.linear.y, t.linear.z) for t in twists], run.command[:, :3])
    np.testing.assert_array_equal(angular, run.command[:, 3:])
    moved = [message.transforms[0] for _, _, message in found["/tf"]]
    np.testing.assert_array_equal([m.transform.translation.y for m in moved], run.pose[:, 1, 3])
    ((stamp, _, description),) = found["/robot_description"]
    assert stamp == 0
    assert sr.Arm.from_urdf(description.data).joint_names == PANDA.joint_names


def test_diagnostics_come_when_something_changes(run, tmp_path):
    run.save(tmp_path / "run.rosbag2")
    (file,) = (tmp_path / "run.rosbag2").glob("*.mcap")
    with file.open("rb") as opened:
        reader = make_reader(opened, decoder_factories=[DecoderFactory()])
        found = [(m.log_time, d) for _, _, m, d in reader.iter_decoded_messages(topics=["/diagnostics"])]
    both = np.hstack([run.health, run.known, run.status[:, None]])
    ticks = [0, *(np.flatnonzero(np.any(np.diff(both, axis=0) != 0, axis=1)) + 1)]
    assert [stamp for stamp, _ in found] == [round(run.time[tick] * 1e9) for tick in ticks]
    for (_, message), tick in zip(found, ticks, strict=True):
        joints = message.status[:7]
        assert [state.name for state in joints] == [f"joint {joint}" for joint in JOINTS]
        assert [state.message for state in joints] == [HEALTHS[int(code)] for code in run.health[tick]]
        assert [state.values[0].value for state in joints] == [HEALTHS[int(code)] for code in run.known[tick]]
        assert [int.from_bytes(state.level) if isinstance(state.level, bytes) else state.level for state in joints] == [
            2 * (code != 0) for code in run.health[tick]
        ]


def test_the_metadata_is_what_humble_reads(run, tmp_path):
    run.save(tmp_path / "run.rosbag2")
    read = yaml.safe_load((tmp_path / "run.rosbag2" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert (read["version"], read["storage_identifier"]) == (8, "mcap")
    assert read["message_count"] == sum(topic["message_count"] for topic in read["topics_with_message_count"])
    for topic in read["topics_with_message_count"]:
        (quality,) = yaml.safe_load(topic["topic_metadata"]["offered_qos_profiles"])
        late = topic["topic_metadata"]["name"] == "/robot_description"
        assert quality["durability"] == (1 if late else 2)  # numbers, not words
        assert quality["reliability"] == 1
        assert topic["topic_metadata"]["serialization_format"] == "cdr"


def test_netcdf_in_plain_xarray(run, tmp_path):
    xarray = pytest.importorskip("xarray")
    run.save(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as read:
        np.testing.assert_array_equal(read["q"].values, run.q)
        assert read["rates"].sel(joint="panda_joint4").shape == (len(run),)
        assert "units" in read["time"].attrs or read["time"].encoding
        assert read.attrs["source"].startswith("stillreach 0.")
        assert read.attrs["instruction_set"] in ("baseline", "avx2", "avx512")
    again = sr.simulate(sr.Run.load(tmp_path / "run.nc").scenario)
    np.testing.assert_array_equal(again.q, run.q)


def test_an_earlier_bag_is_replaced_and_nothing_else(run, tmp_path):
    run.save(tmp_path / "run.rosbag2")
    run.save(tmp_path / "run.rosbag2")
    assert [path.name for path in tmp_path.iterdir()] == ["run.rosbag2"]
    (tmp_path / "other.rosbag2").mkdir()
    (tmp_path / "other.rosbag2" / "mine").write_text("x")
    with pytest.raises(InputError, match=r"path: got 'other.rosbag2', which exists and is no rosbag2"):
        run.save(tmp_path / "other.rosbag2")
    assert (tmp_path / "other.rosbag2" / "mine").read_text() == "x"


def test_other_endings_are_refused(run, tmp_path):
    with pytest.raises(
        InputError, match=r"path: got 'run.xlsx', expected a name that ends with one of .nc, .npz, .csv"
    ):
        run.save(tmp_path / "run.xlsx")
    run.save(tmp_path / "run")
    np.testing.assert_array_equal(sr.Run.load(tmp_path / "run").q, run.q)


def test_the_command_converts(run, tmp_path):
    run.save(tmp_path / "run.npz")
    answer = run_command("convert", "run.npz", "run.csv", folder=tmp_path)
    assert answer.code == 0
    assert "wrote run.csv" in answer.out
    check_table(pd.read_csv(tmp_path / "run.csv"), run)
    assert run_command("convert", "no.nc", "run.csv", folder=tmp_path).code == 2
    assert run_command("convert", "run.npz", "run.pdf", folder=tmp_path).code == 2
