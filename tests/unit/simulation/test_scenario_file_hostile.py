"""Whatever a scenario file holds, it is loaded or refused with ScenarioFileError, and soon."""

import time

import pytest

import stillreach as sr
from tests.unit.simulation.scenario_texts import PLANAR, planar

FULL = 63 * 1024  # as large as a file may be, nearly
HOSTILE = {
    "lists in lists": "a = " + "[" * 20_000 + "]" * 20_000,
    "tables in tables": "a = " + "{a = " * 9_000 + "1" + "}" * 9_000,
    "33 levels": "a = " + "[" * 33 + "]" * 33,
    "a key of 30,000 parts": "a" + ".a" * 30_000 + " = 1",
    "a header of 30,000 parts": "[a" + ".a" * 30_000 + "]",
    "7,000 tables": "".join(f"[a{k}]\n" for k in range(7000)),
    "6,000 keys": "".join(f"k{k}=1\n" for k in range(6000)),
    "200 faults of no kind": planar(tables='[[faults]]\njoint = "j9"\nkind = "lokked"\n' * 200),
    "200 unknown joints": planar(tables='[[faults]]\njoint = "jj"\nkind = "locked"\n' * 200),
    "1,400 faults": planar(tables='[[faults]]\njoint = "j1"\nkind = "locked"\n' * 1400),
    "199 circles": planar(
        tables='[[motion]]\nkind = "circle"\ncentre = [0, 0, 1]\naxis = [0, 1, 1]\nduration = 1\n' * 199
    ),
    "900 circles": planar(
        tables='[[motion]]\nkind = "circle"\ncentre = [0, 0, 1]\naxis = [0, 1, 1]\nduration = 1\n' * 900
    ),
    "31,000 joint values": PLANAR.replace("[0, 0.5, 1]", "[" + "1," * 31_000 + "]"),
    "20,000 texts for numbers": PLANAR.replace("[0, 0.5, 1]", "[" + '"",' * 20_000 + "]"),
    "2,000 points": planar(
        tables='[[motion]]\nkind = "waypoints"\nduration = 5\npoints = [' + "[1,2,3]," * 2000 + "]\n"
    ),
    "6,000 joints by name": "[start]\n" + "".join(f"j{k}x=1\n" for k in range(6000)) + PLANAR[26:],
    "200 joints": PLANAR.replace('"planar"\nn = 3', '"snake"\nn = 200'),
    "a billion joints": PLANAR.replace("n = 3", "n = 1000000000"),
    "5,000 digits": PLANAR.replace("0.5", "9" * 5000),
    "4,000 digits": PLANAR.replace("0.5", "9" * 4000),
    "50,000 digits of a hexadecimal": PLANAR.replace("0.5", "0x" + "f" * 50_000),
    "a huge exponent": PLANAR.replace("0.5", "1e" + "9" * 10_000),
    "a long name": f'name = "{"x" * FULL}"\n',
    "escaped quotes": 'name = "' + '\\"' * (FULL // 2 - 200) + f'"\n{PLANAR}',
    "nearly triple quotes": 'name = """' + '""a' * (FULL // 3 - 200) + f'"""\n{PLANAR}',
    "an open string": 'a = """' + '"' * 2 + "\\" * (FULL - 100),
    "a comment": "#" * FULL,
    "line feeds": "\n" * FULL,
    "open brackets": "[[[[",
    "too large": "#" * (64 * 1024 + 1),
    "ragged weights": planar(tables="[task]\nweights = { joints = [" + "[" + "1," * 50 + "]," + "[1]," * 100 + "] }"),
    "keys like our own marks": '"<line>" = 1\n"<x>" = 2\n"" = 3\n"[key]" = 4\n[start]\n"[key]" = "x"\n"<one>" = "y"\n',
    "marks inside a motion": planar(tables='"<twist>" = 1\n"<x>".a = 1\n'),
    "values in tables of unknown kind": planar(
        top='null_motion = { kind = "xyzzy", q = "abc", rates = [[1], 2, "x"] }\nlaw = { kind = 1, price = [] }',
        tables='[[motion]]\nkind = []\nduration = "x"\npoints = 3\nramp = {}\n[[faults]]\nkind = {}\nrate = "x"\n',
    ),
    "a million seconds in microseconds": planar(top="period = 1e-6\nduration = 1e6"),
    "a billion seconds": planar(top="duration = 1e9"),
    "a zero byte": f"{PLANAR}\x00",
    "carriage returns": PLANAR.replace("\n", "\r"),
    "not a path": PLANAR.replace('arm = "planar"\nn = 3', 'urdf = "a\\u0000b"'),
    "a device for a robot": PLANAR.replace('arm = "planar"\nn = 3', 'urdf = "/dev/zero"'),
    "a package above": PLANAR.replace('arm = "planar"\nn = 3', 'urdf = "package:../../x"'),
    "a package of no name": PLANAR.replace('arm = "planar"\nn = 3', 'urdf = "package:/"'),
    "a file that is no robot": PLANAR.replace('arm = "planar"\nn = 3', 'urdf = "package:numpy/__init__.py"'),
    "a device for a table": planar(tables='[[motion]]\nkind = "pose-table"\nfile = "/dev/zero"\n'),
    "no path for a table": planar(tables='[[motion]]\nkind = "pose-table"\nfile = "\\u0000"\n'),
}


def refusal(load, text):
    """The error of a file, or None where it is loaded; any other error is the test's."""
    try:
        load(text)
    except sr.errors.ScenarioFileError as error:
        return error
    return None


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_a_hostile_file_is_refused_or_loaded_within_a_second(load, text):
    load(PLANAR)  # imports are not its fault
    began = time.process_time()
    error = refusal(load, text)
    assert time.process_time() - began < 1.0
    assert error is None or error.mistakes
    assert len(str(error)) < 100_000


@pytest.mark.parametrize("content", [b"\xff\x00a", b'name = "x"\nb = 1\xff', b"name = '\xed\xa0\x80'"])
def test_bytes_that_are_not_utf8_have_a_line(load, content):
    with pytest.raises(sr.errors.ScenarioFileError, match="not UTF-8") as caught:
        load(content)
    assert caught.value.mistakes[0].line == content.count(b"\n") + 1


@pytest.mark.parametrize("content", [b"\xff\xfea", b"\xfe\xff\xd8\x00"])
def test_bytes_that_are_not_utf16_after_its_mark_are_told(load, content):
    with pytest.raises(sr.errors.ScenarioFileError, match="not UTF-16"):
        load(content)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("no/such/file.toml", "no such file"),
        (".", "a folder"),
        ("/dev/zero", "not a regular file"),
        ("a\x00b", "no such file"),
        ("a\x00b/c.toml", "no such file|null byte"),
        ("x" * 5000, "no such file or ready scenario"),
        ("x/" * 5000, "too long|no such file"),
        ("paper-exampel-2", r"did you mean 'paper-example-2'\?"),
        ("", "no such file|a folder"),
    ],
)
def test_a_path_that_leads_to_no_file_says_so(path, words):
    with pytest.raises(sr.errors.ScenarioFileError, match=words) as caught:
        sr.Scenario.load(path)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("path", [3, None, b"scenario.toml", ["paper-example-2"]])
def test_what_is_no_path_is_refused(path):
    with pytest.raises(sr.InputError, match="path"):
        sr.Scenario.load(path)


def test_a_run_too_long_for_any_memory_is_refused_before_it_begins(mistakes):
    found = mistakes(planar(top="period = 1e-6\nduration = 1e9"))
    assert "1e+15 ticks" in found["duration"].got
