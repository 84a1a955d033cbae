"""stillreach/urdf.hpp reads the chains that Arm.from_urdf reads, and refuses what it refuses, for the same reason."""

import io
import shutil
import subprocess

import numpy as np
import pytest
from cpp_build import ROOT, has_header

import stillreach as sr
from stillreach.errors import RobotFileError
from tests.fuzzing.targets import KINDS, made
from tests.robots.catalogue import URDF
from tests.unit.arm import test_urdf_leftovers as leftovers
from tests.unit.arm import test_urdf_planar as planar
from tests.unit.arm import test_urdf_versions as versions
from tests.unit.arm.test_urdf_mistakes import FAR, GOOD, MISTAKES, long_chain
from tests.unit.arm.urdf_texts import joint, robot

SPOILED = 300
NOT_XML = "well-formed XML"
"""Expected by both readers, in other words and at another place, because each has its own reader of XML."""

pytestmark = pytest.mark.timeout(300)

FOLLOWERS = robot(
    joint("lead", "a", "b", axis="0 0 1", limit='lower="-2" upper="1" velocity="1"'),
    joint("half", "b", "c", xyz="1 0 0", axis="0 1 0", extra='<mimic joint="lead" multiplier="-0.5" offset="0.1"/>'),
    joint("slide", "c", "d", "prismatic", xyz="0 0 1", axis="1 1 0", extra='<mimic joint="half" multiplier="2"/>'),
    joint("own", "d", "e", xyz="0 1 0", rpy="0.1 0.2 0.3", axis="3 0 4"),
)
SOUND = {
    "followers": (FOLLOWERS, {}),
    "followers from the other end": (FOLLOWERS, {"base": "e", "tip": "a"}),
    "a leader outside the chain": (FOLLOWERS, {"base": "b", "tip": "e"}),
    "a held leader": (FOLLOWERS, {"fixed": {"lead": 0.4}}),
    "a long way": (FAR.replace("6e5", "5e5"), {}),
    "many joints": (long_chain(300, "continuous"), {}),
    "too many joints": (long_chain(1001, "continuous"), {}),
    "too long a way": (long_chain(2001), {}),
    "a quaternion": (versions.versioned("1.1", *versions.turned("1 2 -3 4")), {}),
    "a quaternion of any length": (versions.versioned("1.2", *versions.turned("0 1e-200 0 1e-200")), {}),
    "an acceleration": (versions.limited("1.2", 'lower="-1" upper="1" velocity="2" acceleration="5"'), {}),
    "no acceleration": (versions.limited("1.2", 'lower="-1" upper="1" velocity="2" acceleration="0"'), {}),
    "a planar joint": (planar.mobile("0 0 1"), {}),
    "a planar joint of any axis": (planar.mobile("1 -2 3"), {"base": "tip", "tip": "world"}),
    "a planar joint upside down": (planar.mobile("0 0 -1"), {"fixed": {"base_TY": 0.4}}),
    "a tiny axis": (robot(joint("j", "a", "b", axis="1e-200 0 2e-200")), {}),
    "numbers too small": (robot(joint("j", "a", "b", xyz="1e-999 +.5 -5.e-1")), {}),
    "a comment with dashes": (leftovers.ARM.replace("</joint>", "<!-- a -- b --></joint>", 1), {}),
    "a comment that does not end": (leftovers.ARM.replace("<joint", "<!-- <joint", 1), {}),
    "a zero after the end": (leftovers.ARM + "\0\0\n", {}),
    "white space before the declaration": ("\r\n\r\n  " + leftovers.ARM, {}),
    "an instruction": (leftovers.ARM.replace("<joint", "<?note ?><joint", 1), {}),
    "other white space": (GOOD.replace('xyz="0 0 0"', 'xyz="0\u00a00\u20030"', 1), {}),
    "references": (GOOD.replace("elbow", "el&#98;&lt;&amp;&#x20AC;"), {}),
    **{place: (text, {"tip": "c"}) for place, text in leftovers.CALLS.items()},
    **{
        f"{what} twice": (leftovers.ARM.replace("</joint>", f"{leftovers.SECOND[what]}</joint>", 1), {})
        for what in leftovers.SECOND
    },
}
WRONG_XML = {
    "an attribute twice": '<robot name="a" name="b"><link name="a"/></robot>',
    "no space between attributes": '<robot name="a"version="1.0"><link name="a"/></robot>',
    "< in an attribute": '<robot name="<"><link name="a"/></robot>',
    "an attribute without quotes": "<robot name=a><link name='a'/></robot>",
    "a lone ampersand": "<robot>&<link name='a'/></robot>",
    "text behind the root": "<robot><link name='a'/></robot> text",
    "two roots": "<robot><link name='a'/></robot><robot/>",
    "a control character": "<robot>\x01<link name='a'/></robot>",
    "a reference to nothing": "<robot name='&#0;'><link name='a'/></robot>",
    "nothing": "",
    "a late declaration": "<robot><?xml version='1.0'?><link name='a'/></robot>",
    "another tag closed": "<robot><link name='a'></Link></robot>",
}


def cases():
    """(text, arguments) by name."""
    found = {name: (text, {}) for name, (text, *_) in MISTAKES.items()}
    found["a follower far away"] = MISTAKES["a follower far away"][0], {"tip": "c"}
    found |= SOUND | {name: (text, {}) for name, text in WRONG_XML.items()}
    for place, text in enumerate((GOOD, FAR)):
        for tip in ("hnd", "base", "hand", "tip"):
            found[f"{place} {tip}"] = text, {"tip": tip, "base": "base"}
        for held in ({"elbw": 0.0}, {"elbow": 1e7}, {"elbow": 0.3}, {"elbow": 0.0, "shoulder": 0.0}):
            found[f"{place} {held}"] = text, {"fixed": held, "tip": "hand"}
    for name, one in URDF.items():
        found[name] = one.file.read_text("utf-8"), {"tip": one.tip, "base": one.base, "fixed": one.held}
    files = KINDS["urdf"].files()
    for index in range(SPOILED):
        data = made("urdf", KINDS["urdf"], files, 5, index)[0]
        found[f"spoiled {index}"] = data.decode("utf-8", "replace"), {}
    return found


def field(text):
    """A text behind its length."""
    data = text.encode("utf-8", "surrogatepass")
    return b"%d\n%b" % (len(data), data)


def request(text, asked):
    """What the program reads for one case."""
    held = asked.get("fixed") or {}
    words = [asked.get("tip") or "", asked.get("base") or "", str(len(held))]
    return b"".join(map(field, [*words, *(word for name, at in held.items() for word in (name, repr(at))), text]))


def built(folder):
    """The program, built with the first compiler."""
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed")
    program = folder / "urdf_chains"
    source = ROOT / "tests" / "cpp" / "urdf_chains.cpp"
    if not has_header("tinyxml2.h"):
        pytest.skip("apt-get install libtinyxml2-dev")
    command = ["g++", "-std=c++17", "-O0", "-Wno-psabi", f"-I{ROOT / 'include'}", str(source), "-o", str(program)]
    done = subprocess.run([*command, "-ltinyxml2"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return program


def by_python(text, asked):
    """The arm, or the error."""
    try:
        return sr.Arm.from_urdf(io.StringIO(text, newline=""), **asked)
    except RobotFileError as error:
        return error


def numbers(text):
    return np.array([float(word) for word in text.split()])


def check_chain(name, arm, answer):
    """The same joints, tool, pose and Jacobian, up to rounding."""
    kind, robot_name, pose, jacobian, *joints = answer
    assert (kind, robot_name, len(joints)) == ("chain", arm.name, 6 * len(arm.chain)), name
    q = [0.3 * (i % 5) - 0.5 for i in range(arm.n)]
    size = 1.0 + arm.reach if np.isfinite(arm.reach) else 1e6
    assert np.max(np.abs(numbers(pose).reshape(4, 4) - arm.forward(q))) <= 1e-13 * size * (10 + arm.n), name
    J = arm.jacobian(q)
    bound = 1e-13 * size * (10 + arm.n) * (1.0 + np.max(np.abs(J)))
    assert np.max(np.abs(numbers(jacobian).reshape(arm.n, 6).T - J)) <= bound, name
    for moving, got in zip(arm.chain, zip(*[iter(joints)] * 6, strict=True), strict=True):
        own, leader = moving.joint, arm.joint_names[moving.leader]
        assert got[:3] == (own.name, "" if leader == own.name else leader, own.kind), name
        placed = np.abs(numbers(got[3]).reshape(4, 4) - own.placement)
        assert np.max(placed) <= 1e-13 * (1.0 + np.max(np.abs(own.placement))), name
        assert np.max(np.abs(numbers(got[4]) - own.axis)) <= 1e-15, name
        limits = [*own.position_limits, own.velocity_limit, own.acceleration_limit, moving.factor, moving.offset]
        assert numbers(got[5]).tolist() == limits, name


def check_refusal(name, error, answer):
    """The same place and the same words."""
    refused, argument, line, element, got, expected = answer
    assert refused == "refused", name
    if NOT_XML in (expected, error.expected) or error.expected == "UTF-8":
        return
    ours = ("" if error.argument == "path" else error.argument, str(error.line or 0), error.element or "", error.got)
    if "\\" in "".join(ours):  # characters that Python does not show
        return
    assert (argument, line, element, got.replace("no tip", "None")) == ours, name


def test_both_readers_read_the_same_chains_and_refuse_the_same_texts(tmp_path):
    program, texts = built(tmp_path), cases()
    asked = b"".join(request(text, settings) for text, settings in texts.values())
    done = subprocess.run([program], input=asked, capture_output=True, check=True)
    answers = done.stdout.decode().split("\n")[:-1]
    assert len(answers) == len(texts)
    read = refused = 0
    for (name, (text, settings)), answer in zip(texts.items(), answers, strict=True):
        expected, fields = by_python(text, settings), answer.split("\x1f")[:-1]
        if isinstance(expected, RobotFileError):
            check_refusal(name, expected, fields)
            refused += 1
        else:
            check_chain(name, expected, fields)
            read += 1
    assert min(read, refused) > 80
