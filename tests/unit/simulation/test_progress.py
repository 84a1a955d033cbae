"""The progress bar: names as they are, and processes without standard error."""

import io
import sys

import pytest

from stillreach.simulation.progress import Progress


def shown(name):
    with Progress(name, 2, True) as bar:
        bar.update(1)
        bar.update(2)


@pytest.mark.parametrize("name", ["part [/] of two", "[/red]", "[red]x"])
def test_a_name_is_not_read_as_markup(capsys, name):
    shown(name)
    assert name in capsys.readouterr().err


def test_control_characters_of_a_name_do_not_reach_the_terminal(capsys):
    shown("a\x1b[2Jb\0")
    err = capsys.readouterr().err
    assert "\x1b[2J" not in err
    assert r"a\x1b[2Jb\x00" in err


def closed():
    stream = io.StringIO()
    stream.close()
    return stream


@pytest.mark.parametrize("show", [None, True])
@pytest.mark.parametrize("stream", [lambda: None, closed], ids=["none", "closed"])
def test_without_standard_error_there_is_no_bar(monkeypatch, show, stream):
    monkeypatch.setattr(sys, "stderr", stream())
    with Progress("a", 2, show) as bar:
        bar.update(2)
