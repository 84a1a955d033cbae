"""Files that are written whole or not at all."""

import os
import stat

import pytest

from stillreach._files import new_file
from tests.refusals import refused


def write(path, content=b"new"):
    with new_file(path) as file:
        file.write(content)


def test_a_new_file_appears_with_the_rights_of_any_new_file(tmp_path):
    write(tmp_path / "a")
    (tmp_path / "b").write_bytes(b"")
    assert (tmp_path / "a").read_bytes() == b"new"
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_a_private_file_stays_private(tmp_path):
    (tmp_path / "a").write_bytes(b"old")
    (tmp_path / "a").chmod(0o600)
    write(tmp_path / "a")
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o600
    assert (tmp_path / "a").read_bytes() == b"new"


@pytest.mark.parametrize("there", [True, False])
def test_a_link_stays_and_its_file_is_written(tmp_path, there):
    folder = tmp_path / "folder"
    folder.mkdir()
    if there:
        (folder / "a").write_bytes(b"old")
    (tmp_path / "link").symlink_to(folder / "a")
    write(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert (folder / "a").read_bytes() == b"new"


def test_the_longest_name_is_written(tmp_path):
    write(tmp_path / ("x" * 255))
    assert [len(path.name) for path in tmp_path.iterdir()] == [255]


def test_a_pipe_is_refused_and_left_alone(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with refused("path", "pipe"):
        write(tmp_path / "pipe")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert [path.name for path in tmp_path.iterdir()] == ["pipe"]


@pytest.mark.parametrize("value", ["a\0b", 3, None, ["a"]])
def test_what_is_no_name_is_refused(value):
    with refused("path"):
        write(value)


@pytest.mark.parametrize(("name", "error"), [("", OSError), (".", IsADirectoryError), ("no/a", FileNotFoundError)])
def test_an_error_has_the_name_that_the_caller_knows(tmp_path, monkeypatch, name, error):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error) as caught:
        write(name)
    assert caught.value.filename == name
    assert [path.name for path in tmp_path.iterdir()] == []


@pytest.mark.parametrize("unnamed", [True, False], ids=["without a name", "with a name of ours"])
def test_an_error_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, unnamed):
    if not unnamed:
        monkeypatch.delattr(os, "O_TMPFILE", raising=False)
    (tmp_path / "a").write_bytes(b"old")
    with pytest.raises(TypeError):
        write(tmp_path / "a", content="no bytes")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"old"
    write(tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"new"


@pytest.mark.skipif(not hasattr(os, "O_TMPFILE"), reason="files without a name are Linux's")
def test_until_it_is_complete_the_file_has_no_name(tmp_path):
    with new_file(tmp_path / "a") as file:
        file.write(b"half")
        file.flush()
        assert [path.name for path in tmp_path.iterdir()] == []
