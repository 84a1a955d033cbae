"""The motion of a tool from bags that have its poses alone."""

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

import stillreach as sr
from tests.commands import run_command
from tests.refusals import refused

PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
TIME = np.arange(0.0, 3.0, 0.02)
Q = START + 0.1 * np.sin(np.outer(TIME, [0.5, 0.7, 0.3, 0.6, 0.4, 0.8, 0.2]))
POSES = PANDA.forward(Q)
STORE = get_typestore(Stores.ROS2_HUMBLE)
EPOCH = 1_700_000_000 * 10**9


def made(kind, *values):
    return STORE.types[kind](*values)


def header(time, frame):
    return made(
        "std_msgs/msg/Header", made("builtin_interfaces/msg/Time", *divmod(EPOCH + round(1e9 * time), 10**9)), frame
    )


def turn(T):
    return made("geometry_msgs/msg/Quaternion", *Rotation.from_matrix(T[:3, :3]).as_quat().tolist())


def pose(time, T, frame="base"):
    place = made("geometry_msgs/msg/Point", *T[:3, 3].tolist())
    return made("geometry_msgs/msg/PoseStamped", header(time, frame), made("geometry_msgs/msg/Pose", place, turn(T)))


def transform(time, T, frame, child):
    moved = made("geometry_msgs/msg/Transform", made("geometry_msgs/msg/Vector3", *T[:3, 3].tolist()), turn(T))
    return made("geometry_msgs/msg/TransformStamped", header(time, frame), child, moved)


def bag(path, *messages, storage=StoragePlugin.MCAP):
    """A rosbag2 of (topic, message) in this order."""
    with Writer(path, version=8, storage_plugin=storage) as writer:
        channels = {}
        for number, (topic, message) in enumerate(messages):
            kind = message.__msgtype__
            if topic not in channels:
                channels[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(channels[topic], EPOCH + number, STORE.serialize_cdr(message, kind))
    return path


def poses(path, **options):
    return bag(path, *(("/tool", pose(t, T)) for t, T in zip(TIME, POSES, strict=True)), **options)


def placed(degrees, *place):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_euler("xyz", degrees, degrees=True).as_matrix(), place
    return T


FLANGE, MOUNT = placed([0, 0, 90], 0.0, 0.0, 0.1), placed([0, 180, 0], 1.0, 0.5, 0.0)


def tree(path):
    """base -> flange moves, world -> base and flange -> tool do not; a camera moves elsewhere."""
    still = [transform(0.0, FLANGE, "flange", "tool"), transform(0.0, MOUNT, "world", "base")]
    messages = []
    for t, T in zip(TIME, POSES, strict=True):
        messages.append(
            ("/tf", made("tf2_msgs/msg/TFMessage", [transform(t, T @ np.linalg.inv(FLANGE), "base", "flange")]))
        )
        messages.append(("/tf", made("tf2_msgs/msg/TFMessage", [transform(t + 0.001, T, "world", "camera")])))
    messages.insert(3, ("/tf_static", made("tf2_msgs/msg/TFMessage", still)))
    return bag(path, *messages)


def same(motion, wanted=POSES):
    np.testing.assert_allclose(motion.times, TIME, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.points, wanted[:, :3, 3], atol=1e-12)
    np.testing.assert_allclose(motion.orientations, wanted[:, :3, :3], atol=1e-12)


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_poses(tmp_path, storage):
    same(sr.Recording.tool_motion(poses(tmp_path / "a", storage=storage)))
    same(sr.Recording.tool_motion(tmp_path / "a", topic="/tool", frame="base"))


def test_transforms_of_a_tree(tmp_path):
    path = tree(tmp_path / "a")
    same(sr.Recording.tool_motion(path, frame="base", child="tool"))
    same(sr.Recording.tool_motion(path, child="tool"), MOUNT @ POSES)
    with refused("child", "camera", "tool"):
        sr.Recording.tool_motion(path)
    with refused("child", "tool"):
        sr.Recording.tool_motion(path, child="tol")
    with refused("frame", "base", "world"):
        sr.Recording.tool_motion(path, child="tool", frame="camera")


def test_transforms_of_one_frame_without_a_tree(tmp_path):
    path = bag(tmp_path / "a", *(("/mocap", transform(t, T, "room", "hand")) for t, T in zip(TIME, POSES, strict=True)))
    same(sr.Recording.tool_motion(path))


def test_a_file_without_an_end(tmp_path):
    (file,) = poses(tmp_path / "a").glob("*.mcap")
    (tmp_path / "cut.mcap").write_bytes(file.read_bytes()[:-4000])
    motion = sr.Recording.tool_motion(tmp_path / "cut.mcap")
    assert 0 < len(motion.times) <= len(TIME)
    np.testing.assert_allclose(motion.points, POSES[: len(motion.times), :3, 3], atol=1e-12)


def test_our_own_runs_have_poses(tmp_path):
    run = sr.simulate(sr.Scenario(arm=PANDA, start=START, motion=sr.Line([0.0, 0.1, 0.0], duration=1.0, relative=True)))
    run.save(tmp_path / "run.rosbag2")
    motion = sr.Recording.tool_motion(tmp_path / "run.rosbag2", topic="/tool_pose")
    np.testing.assert_array_equal(motion.points, run.pose[:, :3, 3])
    again = sr.Recording.tool_motion(tmp_path / "run.rosbag2", topic="/tf", frame="base", child="tool")
    np.testing.assert_array_equal(again.points, run.pose[:, :3, 3])
    with refused("topic", "/target_pose", "/tf", "/tool_pose"):
        sr.Recording.tool_motion(tmp_path / "run.rosbag2")
    with refused("child", "tool"):
        sr.Recording.tool_motion(tmp_path / "run.rosbag2", topic="/tool_pose", child="tool")


def test_mistakes(tmp_path):
    with pytest.raises(FileNotFoundError):
        sr.Recording.tool_motion(tmp_path / "nothing.mcap")
    (tmp_path / "a.csv").write_text("time,x\n0,0\n")
    with refused("path", "a.csv"):
        sr.Recording.tool_motion(tmp_path / "a.csv")
    two = bag(tmp_path / "two", ("/tool", pose(0.0, POSES[0])), ("/tool", pose(0.1, POSES[1], "other")))
    with refused("topic", "base", "other"):
        sr.Recording.tool_motion(two)
    late = bag(tmp_path / "late", *(("/tool", pose(t, POSES[0])) for t in (0.0, 0.02, 0.01)))
    with refused("time", "pose 2"):
        sr.Recording.tool_motion(late)
    assert sr.Recording.tool_motion(late, sort=True).times.tolist() == pytest.approx([0.0, 0.01, 0.02], abs=1e-9)


def test_a_tree_that_is_none(tmp_path):
    def told(*parts):
        return ("/tf", made("tf2_msgs/msg/TFMessage", [transform(t, POSES[0], *names) for t, *names in parts]))

    cycle = bag(tmp_path / "cycle", told((0.0, "a", "b"), (0.0, "b", "a")))
    for child in (None, "a"):
        with refused("child", "a"):
            sr.Recording.tool_motion(cycle, child=child)
    moved = bag(tmp_path / "moved", told((0.0, "a", "t")), told((0.1, "b", "t")))
    with refused("child", "'a'", "'b'"):
        sr.Recording.tool_motion(moved)
    empty = bag(tmp_path / "empty", told(), told())
    with refused("topic", "empty"):
        sr.Recording.tool_motion(empty)


def test_a_static_transform_that_is_told_again_is_no_motion(tmp_path):
    still = ("/r/tf_static", made("tf2_msgs/msg/TFMessage", [transform(-50.0, FLANGE, "flange", "tool")]))
    moving = [
        ("/r/tf", made("tf2_msgs/msg/TFMessage", [transform(t, T @ np.linalg.inv(FLANGE), "base", "flange")]))
        for t, T in zip(TIME, POSES, strict=True)
    ]
    same(sr.Recording.tool_motion(bag(tmp_path / "a", still, *moving[:70], still, *moving[70:])))


def test_a_command_reads_a_file_without_an_end(tmp_path):
    (file,) = poses(tmp_path / "a").glob("*.mcap")
    (tmp_path / "cut.mcap").write_bytes(file.read_bytes()[:-4000])
    options = ("--robot", "panda", "--topic", "/tool", "--out", tmp_path / "out", "--no-plot")
    answer = run_command("run", "--recording", tmp_path / "cut.mcap", *options)
    assert answer.code == 0, answer.err


def test_a_command_runs_on_it(tmp_path):
    poses(tmp_path / "a")
    options = (
        "--robot",
        "panda",
        "--topic",
        "/tool",
        "--fail",
        "panda_joint3@1",
        "--out",
        tmp_path / "out",
        "--no-plot",
    )
    answer = run_command("run", "--recording", tmp_path / "a", *options)
    assert answer.code == 0, answer.err
    run = sr.Run.load(tmp_path / "out" / "run.nc")
    np.testing.assert_allclose(run.pose[0], POSES[0], atol=1e-8)
    away = np.linalg.norm(run.pose[:, :3, 3] - run.target[:, :3, 3], axis=1)
    assert away.max() < 2e-3
    far = POSES.copy()
    far[:, 0, 3] += 5.0
    bag(tmp_path / "far", *(("/tool", pose(t, T)) for t, T in zip(TIME, far, strict=True)))
    refusal = run_command("run", "--recording", tmp_path / "far", "--robot", "panda", "--topic", "/tool")
    assert refusal.code != 0
    assert "does not reach" in refusal.err
