"""Robots from file objects: standard input, pipes, files in memory."""

import io
import os
import subprocess
import sys

import pytest

import stillreach as sr
from tests.unit.arm.urdf_texts import joint, robot

TEXT = robot(joint("ölbogen", "a", "b"), joint("k", "b", "c"), name="from a stream")
ARM = sr.Arm.from_urdf(TEXT)


@pytest.mark.parametrize(
    "stream",
    [
        io.StringIO(TEXT),
        io.BytesIO(TEXT.encode()),
        io.BytesIO(TEXT.encode("utf-8-sig")),
        io.BytesIO(TEXT.encode("utf-16")),
        io.TextIOWrapper(io.BytesIO(TEXT.encode()), encoding="utf-8"),
        io.BufferedReader(io.BytesIO(TEXT.encode())),
    ],
    ids=lambda stream: type(stream).__name__,
)
def test_any_file_object_is_read(stream):
    assert sr.Arm.from_urdf(stream) == ARM


def test_a_pipe_that_gives_a_little_at_a_time_is_read_to_its_end():
    read, write = os.pipe()
    pieces = [TEXT.encode()[k : k + 7] for k in range(0, len(TEXT.encode()), 7)]
    with os.fdopen(read, "rb", buffering=0) as stream:
        with os.fdopen(write, "wb", buffering=0) as other:
            for piece in pieces:
                other.write(piece)
        assert sr.Arm.from_urdf(stream) == ARM


def test_standard_input_is_read_in_either_form():
    for source in ("sys.stdin", "sys.stdin.buffer"):
        code = f"import stillreach as sr, sys; print(sr.Arm.from_urdf({source}).joint_names[1])"
        environment = os.environ | {"PYTHONIOENCODING": "utf-8"}
        done = subprocess.run(
            [sys.executable, "-c", code], input=TEXT.encode(), capture_output=True, check=True, env=environment
        )
        assert done.stdout.split() == [b"k"]


def test_an_open_file_gives_its_name_to_the_arm_and_to_messages(tmp_path):
    path = tmp_path / "seven.urdf"
    path.write_text(TEXT.replace("from a stream", ""), encoding="utf-8")
    with path.open("rb") as file:
        assert sr.Arm.from_urdf(file).name == "seven"
    with path.open("rb") as file, pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_urdf(file, tip="d")
    assert caught.value.file == str(path)


class Odd:
    def __init__(self, part):
        self.part = part

    def read(self, size):
        return self.part


def closed():
    stream = io.BytesIO(TEXT.encode())
    stream.close()
    return stream


@pytest.mark.parametrize(
    ("stream", "part"),
    [
        (io.BytesIO(b""), "no element found"),
        (io.TextIOWrapper(io.BytesIO(b"\xff<robot/>"), encoding="utf-8"), "open it in binary mode"),
        (closed(), "I/O operation on closed file"),
        (Odd(7), "got 7 from its read()"),
        (Odd(b"<a/>" * 1000), "more than 16 MiB"),
        (Odd("<a/>" * 1000), "more than 16 MiB"),
        (Odd(None), "no element found"),
    ],
)
def test_a_stream_that_is_no_robot_is_told(stream, part):
    with pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_urdf(stream)
    assert part in str(caught.value)
    assert len(str(caught.value)) < 300
