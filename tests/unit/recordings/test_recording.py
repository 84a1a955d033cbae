"""Recordings that other tools wrote: the same motion from every format, and errors that say what to do."""

import contextlib
import json

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import stillreach as sr
from stillreach import InputError
from tests.commands import run_command

PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
TIME = np.arange(0.0, 4.0, 0.02)
Q = START + 0.2 * np.sin(np.outer(TIME, [0.5, 0.7, 0.3, 0.6, 0.4, 0.8, 0.2]))
JOINTS = list(PANDA.joint_names)
STORE = get_typestore(Stores.ROS2_HUMBLE)
EPOCH = 1_700_000_000 * 10**9
FINGERS = ["panda_finger_joint1", "panda_finger_joint2"]


def frame(q=Q, time=TIME):
    table = pd.DataFrame(np.asarray(q), columns=JOINTS)
    table.insert(3, "time", np.asarray(time))
    return table


def bag(path, storage, *, names=JOINTS, stamped=True, topics=("/joint_states",), rows=Q):
    """A rosbag2 with joints in reverse order beside those of a gripper, which also publishes alone."""
    kinds = STORE.types
    order = [*FINGERS, *reversed(names)]
    with Writer(path, version=8, storage_plugin=storage) as writer:
        channels = [writer.add_connection(topic, "sensor_msgs/msg/JointState", typestore=STORE) for topic in topics]
        for k, (t, q) in enumerate(zip(TIME, rows, strict=True)):
            stamp = EPOCH + round(t * 1e9)
            time = kinds["builtin_interfaces/msg/Time"](*(divmod(stamp, 10**9) if stamped else (0, 0)))
            header = kinds["std_msgs/msg/Header"](time, "")

            def message(joints, values, header=header):
                none = np.zeros(0)
                return kinds["sensor_msgs/msg/JointState"](header, list(joints), np.array(values), none, none)

            for channel in channels:
                if k % 3 == 0:
                    alone = message(FINGERS, [0.01, 0.02])
                    writer.write(channel, stamp, STORE.serialize_cdr(alone, "sensor_msgs/msg/JointState"))
                whole = message(order, [0.01, 0.02, *reversed(q)])
                late = 3_000_000 if stamped else 0  # the recorder's clock is not the robot's
                writer.write(channel, stamp + late, STORE.serialize_cdr(whole, "sensor_msgs/msg/JointState"))
    return path


def lerobot(folder, *, episodes=1, names=JOINTS):
    """A dataset in the layout of LeRobot, but in double precision, so that it can equal the others to 1e-9."""
    data = folder / "data" / "chunk-000"
    data.mkdir(parents=True)
    (folder / "meta").mkdir()
    info = {"features": {"observation.state": {"dtype": "float64", "shape": [7], "names": {"motors": names}}}}
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    parts = [
        pd.DataFrame({"observation.state": list(Q + k), "timestamp": TIME, "episode_index": k}) for k in range(episodes)
    ]
    pd.concat(parts).to_parquet(data / "file-000.parquet", index=False)
    return data / "file-000.parquet"


def saved(path, q=Q, **options):
    frame(q).to_csv(path, index=False, **options)
    return path


FORMATS = {
    "CSV": lambda folder: (saved(folder / "a.csv"), {"angle": "rad"}),
    "CSV in degrees": lambda folder: (saved(folder / "a.csv", np.rad2deg(Q)), {"angle": "deg"}),
    "CSV with semicolons and decimal commas": lambda folder: (
        saved(folder / "a.csv", sep=";", decimal=","),
        {"angle": "rad"},
    ),
    "Parquet": lambda folder: (frame().to_parquet(folder / "a.parquet") or folder / "a.parquet", {"angle": "rad"}),
    "LeRobot": lambda folder: (lerobot(folder), {"angle": "rad"}),
    "rosbag2, SQLite": lambda folder: (bag(folder / "a", StoragePlugin.SQLITE3), {}),
    "rosbag2, MCAP": lambda folder: (bag(folder / "a", StoragePlugin.MCAP), {}),
    "MCAP alone": lambda folder: (next(bag(folder / "a", StoragePlugin.MCAP).glob("*.mcap")), {}),
    "SQLite alone": lambda folder: (next(bag(folder / "a", StoragePlugin.SQLITE3).glob("*.db3")), {}),
    "bag without stamps": lambda folder: (bag(folder / "a", StoragePlugin.MCAP, stamped=False), {}),
}


@pytest.mark.parametrize("way", FORMATS)
def test_every_format_gives_the_same_motion(tmp_path, way):
    path, options = FORMATS[way](tmp_path)
    recording = sr.Recording.load(path, arm=PANDA, **options)
    np.testing.assert_allclose(recording.time, TIME, rtol=0, atol=1e-9)
    np.testing.assert_allclose(recording.q, Q, rtol=0, atol=1e-9)
    motion = recording.as_motion()
    model = pin.buildModelFromXML(PANDA.to_urdf())
    data = model.createData()
    tool = model.getFrameId(model.frames[model.nframes - 1].name)
    for k in range(0, len(TIME), 37):
        pin.framesForwardKinematics(model, data, Q[k])
        np.testing.assert_allclose(motion.points[k], data.oMf[tool].translation, rtol=0, atol=1e-9)
        np.testing.assert_allclose(motion.orientations[k], data.oMf[tool].rotation, rtol=0, atol=1e-9)


def test_a_folder_that_a_crash_left_without_metadata(tmp_path):
    for storage in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
        path = bag(tmp_path / storage.name, storage)
        (path / "metadata.yaml").unlink()
        np.testing.assert_allclose(sr.Recording.load(path, arm=PANDA).q, Q, rtol=0, atol=1e-12)


@pytest.mark.parametrize("suffix", [".nc", ".npz"])
def test_a_run_is_a_recording(tmp_path, suffix):
    run = sr.simulate(sr.Recording(PANDA, TIME, Q).scenario())
    run.save(tmp_path / f"run{suffix}")
    recording = sr.Recording.load(tmp_path / f"run{suffix}", arm=PANDA)
    assert np.array_equal(recording.q, run.q)
    np.testing.assert_allclose(recording.time, run.time, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "name",
    ["{}.pos", "position.{}", "{}_position", "{} [rad]", "{}_rad", "q_{}", "{} (deg)", "joint_positions/{}"],
)
def test_columns_are_found_by_the_joints_names(tmp_path, name):
    degrees = "deg" in name
    table = frame(np.rad2deg(Q) if degrees else Q).rename(columns={joint: name.format(joint) for joint in JOINTS})
    table["panda_joint1_velocity"] = 7.0
    table["note"] = "text"
    table.to_csv(tmp_path / "a.csv", index=False)
    recording = sr.Recording.load(tmp_path / "a.csv", arm=PANDA, angle="rad")  # what the file says holds
    np.testing.assert_allclose(recording.q, Q, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "unit"), [("t", 1.0), ("time [ms]", 1e-3), ("timestamp_ns", 1e-9), ("Time (us)", 1e-6)]
)
def test_times_with_units(tmp_path, name, unit):
    frame(time=TIME / unit).rename(columns={"time": name}).to_csv(tmp_path / "a.csv", index=False)
    np.testing.assert_allclose(sr.Recording.load(tmp_path / "a.csv", arm=PANDA, angle="rad").time, TIME, atol=1e-9)


def test_dates_in_parquet(tmp_path):
    frame(time=pd.to_datetime(EPOCH + np.round(TIME * 1e9).astype(np.int64))).to_parquet(tmp_path / "a.parquet")
    recording = sr.Recording.load(tmp_path / "a.parquet", arm=PANDA, angle="rad")
    np.testing.assert_allclose(recording.time, TIME, rtol=0, atol=1e-9)


def test_joints_of_other_names(tmp_path):
    names = [f"axis{k}" for k in range(7)]
    path = bag(tmp_path / "a", StoragePlugin.MCAP, names=names)
    joints = dict(zip(JOINTS, names, strict=True))
    np.testing.assert_array_equal(sr.Recording.load(path, arm=PANDA, joints=joints).q, Q)


def test_unsorted_samples_and_gaps_are_accepted_on_request(tmp_path):
    table = frame()
    table = pd.concat([table.iloc[100:], table.iloc[:100], table.iloc[[50]] + 0.0]).drop(index=range(120, 140))
    table.to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(InputError, match=r"an earlier time in row of numbers 81.*sort=True"):
        sr.Recording.load(tmp_path / "a.csv", arm=PANDA, angle="rad")
    with pytest.raises(InputError, match=r"a gap of 0\.42 s after row of numbers 120.*largest_gap=0\.42"):
        sr.Recording.load(tmp_path / "a.csv", arm=PANDA, angle="rad", sort=True)
    recording = sr.Recording.load(tmp_path / "a.csv", arm=PANDA, angle="rad", sort=True, largest_gap=0.42)
    kept = np.delete(np.arange(len(TIME)), np.arange(120, 140))
    np.testing.assert_allclose(recording.q, Q[kept], rtol=0, atol=1e-12)
    middle = (Q[119] + Q[140]) / 2.0  # linear across the gap
    np.testing.assert_allclose(recording.at([(TIME[119] + TIME[140]) / 2.0])[0], middle, rtol=0, atol=1e-12)


@pytest.mark.parametrize("share", [0.3, 0.7, 0.99, 1.0])
@pytest.mark.parametrize("alone", [True, False])
def test_what_a_crash_left_of_an_mcap_is_read(tmp_path, share, alone):
    """A file that ends anywhere: everything before its last whole chunk is there."""
    path = tmp_path / "a"
    with rosbag_in_chunks(path) as file:
        whole = file.read_bytes()
    file.write_bytes(whole[: round(share * (len(whole) - 100))])
    (path / "metadata.yaml").unlink()
    recording = sr.Recording.load(file if alone else path, arm=PANDA)
    assert recording.cut
    count = len(recording)
    np.testing.assert_array_equal(recording.q, Q[:count])
    assert abs(count - share * len(TIME)) < 0.25 * len(TIME)


def test_a_whole_file_is_not_cut(tmp_path):
    assert not sr.Recording.load(bag(tmp_path / "a", StoragePlugin.MCAP), arm=PANDA).cut


@contextlib.contextmanager
def rosbag_in_chunks(path):
    """A rosbag2 whose MCAP file has many small chunks, as a recorder writes them."""
    bag(path, StoragePlugin.MCAP)
    (file,) = path.glob("*.mcap")
    with file.open("rb") as opened:
        reader = make_reader(opened)
        read = [(schema, channel, message) for schema, channel, message in reader.iter_messages()]
    with file.open("wb") as opened:
        writer = McapWriter(opened, chunk_size=4096)
        writer.start()
        schemas, channels = {}, {}
        for schema, channel, message in read:
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(channel.topic, "cdr", schemas[schema.id])
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()
    yield file


def unsaid(folder):
    return saved(folder / "a.csv"), {}


def with_column(name, values):
    def made(folder):
        frame().assign(**{name: values}).to_csv(folder / "a.csv", index=False)
        return folder / "a.csv", {"angle": "rad"}

    return made


def without(*columns):
    def made(folder):
        frame().drop(columns=list(columns)).to_csv(folder / "a.csv", index=False)
        return folder / "a.csv", {"angle": "rad"}

    return made


def partial(folder):
    return bag(folder / "a", StoragePlugin.MCAP, names=[*JOINTS[:6], "wrist"]), {}


def empty_folder(folder):
    (folder / "a").mkdir()
    return folder / "a", {}


def wrong_bytes(name):
    def made(folder):
        (folder / name).write_bytes(b"nothing of the kind")
        return folder / name, {"angle": "rad"}

    return made


MISTAKES = {
    "the unit is not said": (
        unsaid,
        r'angle: got none, and the file does not say .* expected angle="rad" or angle="deg"',
    ),
    "degrees as radians": (
        lambda folder: (saved(folder / "a.csv", np.rad2deg(Q)), {"angle": "rad"}),
        r'q: got panda_joint1 at 20 rad after 0 s, .*is it in degrees \(angle="deg"\)',
    ),
    "a joint is missing": (without(JOINTS[3]), r"joints: got no panda_joint4 in a.csv, which has .*expected a column"),
    "no times": (without("time"), r"time: got no column of times in a.csv, which has .*expected a column 'time'"),
    "not a number": (with_column(JOINTS[0], "x"), r"a.csv:2: got 'x' in column panda_joint1, expected a number"),
    "the same time twice": (with_column("time", 0.5), r"time: got the same time in row of numbers 2, .*sort=True"),
    "several topics": (
        lambda folder: (bag(folder / "a", StoragePlugin.MCAP, topics=("/a", "/b")), {}),
        r"topic: got none of 2 with joint states, expected one of '/a', '/b'",
    ),
    "another topic": (
        lambda folder: (bag(folder / "a", StoragePlugin.MCAP), {"topic": "/joint_state"}),
        r"topic: got '/joint_state', expected '/joint_states' \(did you mean '/joint_states'\?\)",
    ),
    "a topic of a table": (
        lambda folder: (saved(folder / "a.csv"), {"topic": "/x"}),
        r"topic: got '/x', expected none for a.csv",
    ),
    "a part of the joints": (
        partial,
        r"joints: got a message \(after 0 whole ones\) without panda_joint7; it has .*wrist",
    ),
    "none of the joints": (
        lambda folder: (bag(folder / "a", StoragePlugin.MCAP, names=[f"x{k}" for k in range(7)]), {}),
        r"joints: got no message with panda_joint1,.* in a, expected messages with every joint",
    ),
    "an empty folder": (empty_folder, r"path: got 'a', a folder with neither metadata.yaml nor MCAP"),
    "not MCAP": (wrong_bytes("a.mcap"), r"path: got 'a.mcap': .*expected a rosbag2"),
    "not SQLite": (wrong_bytes("a.db3"), r"path: got 'a.db3': .*expected a rosbag2"),
    "not Parquet": (wrong_bytes("a.parquet"), r"path: got 'a.parquet', .*expected a Parquet file"),
    "not a recording": (wrong_bytes("a.bin"), r"path: got 'a.bin', expected a rosbag2 folder or a file that ends with"),
    "several episodes": (
        lambda folder: (lerobot(folder, episodes=2), {"angle": "rad"}),
        r"episode: got none of 2 episodes, expected one of 0 … 1",
    ),
    "no such episode": (
        lambda folder: (lerobot(folder, episodes=2), {"angle": "rad", "episode": 5}),
        r"episode: got 5, expected one of 0 … 1",
    ),
    "too few names": (
        lambda folder: (lerobot(folder, names=JOINTS[:6]), {"angle": "rad"}),
        r"path: got info.json with other names, expected 7 names",
    ),
    "an unknown joint": (
        lambda folder: (saved(folder / "a.csv"), {"angle": "rad", "joints": {"j1": "x"}}),
        r"joint: got 'j1', expected one of panda_joint1 … panda_joint7",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_named_with_advice(tmp_path, mistake):
    make, said = MISTAKES[mistake]
    path, options = make(tmp_path)
    with pytest.raises(InputError, match=said):
        sr.Recording.load(path, arm=PANDA, **options)


def test_two_columns_for_one_joint_are_refused(tmp_path):
    frame().assign(q_panda_joint2=0.0).rename(columns={"panda_joint2": "panda_joint2.pos"}).to_csv(tmp_path / "a.csv")
    with pytest.raises(InputError, match=r"joints: got 'panda_joint2.pos' and 'q_panda_joint2' for panda_joint2"):
        sr.Recording.load(tmp_path / "a.csv", arm=PANDA, angle="rad")


def test_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        sr.Recording.load(tmp_path / "no.csv", arm=PANDA)


def test_the_elbow_locks_on_a_recording(tmp_path):
    recording = sr.Recording.load(bag(tmp_path / "a", StoragePlugin.MCAP), arm=PANDA)
    whole = sr.simulate(recording.scenario())
    assert whole.summary().finished
    assert np.abs(whole.pose[:, :3, 3] - whole.target[:, :3, 3]).max() < 1e-3
    broken = sr.simulate(recording.scenario(faults=[sr.Fault(3, at=1.0)]))
    assert np.ptp(broken.q[100:, 3]) == 0.0
    assert np.ptp(broken.q[:100, 3]) > 0.01


def test_the_motion_at_other_times():
    recording = sr.Recording(PANDA, TIME, Q)
    motion = recording.as_motion(every=0.5)
    assert motion.times.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, TIME[-1]]
    np.testing.assert_allclose(motion.points, PANDA.forward(recording.at(motion.times))[:, :3, 3], rtol=0, atol=1e-15)
    tool = np.eye(4)
    tool[:3, 3] = [0.0, 0.0, 0.1]
    np.testing.assert_allclose(recording.as_motion(tool=tool).points, (PANDA.forward(Q) @ tool)[:, :3, 3], atol=1e-14)
    task = sr.Task(rows="position", tool=tool)
    assert sr.simulate(recording.scenario(task=task)).summary().finished


def test_the_command_runs_a_recording(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    saved(tmp_path / "drive.csv", np.rad2deg(Q))
    (tmp_path / "panda.urdf").write_text(PANDA.to_urdf())
    options = ["--recording", "drive.csv", "--robot", "panda.urdf", "--angle", "deg"]
    answer = run_command("run", *options, "--fail", "panda_joint4@1", "--no-plot", "--json")
    found = json.loads(answer.out)
    assert found["faults"][0]["joint"] == "panda_joint4"
    assert (tmp_path / "out" / "drive" / "summary.json").is_file()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "SCENARIO: got nothing"),
        (["reach.toml", "--robot", "panda"], "--robot: got 'panda', expected a --recording with it"),
        (["reach.toml", "--recording", "drive.csv"], "SCENARIO: got 'reach.toml' and a recording"),
        (["--recording", "drive.csv"], "--robot: got nothing"),
        (["--recording", "drive.csv", "--robot", "panda"], "--angle: got none"),
        (["--recording", "no.csv", "--robot", "panda"], "--recording: got 'no.csv'"),
        (["--recording", "drive.csv", "--robot", "panda", "--angle", "rad", "--topic", "/x"], "--topic: got '/x'"),
    ],
)
def test_options_that_do_not_go_together(tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    saved(tmp_path / "drive.csv")
    answer = run_command("run", *options, "--no-plot")
    assert answer.code == 2
    assert said in " ".join(answer.err.split())
