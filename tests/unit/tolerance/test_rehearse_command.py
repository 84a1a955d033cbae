"""The command that rehearses, and its page."""

import base64
import gzip
import json
import re
import shlex
import xml.etree.ElementTree as ET
from importlib.util import find_spec

import numpy as np
import pytest

import stillreach as sr
from tests.browser import chromium
from tests.commands import run_command
from tests.unit.tolerance.test_rehearse import PANDA, RECORDED


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A folder with a robot and a recording."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "panda.urdf").write_text(PANDA.to_urdf())
    header = ",".join(["time", *(f"{joint} [rad]" for joint in PANDA.joint_names)])
    table = np.column_stack([RECORDED.time, RECORDED.q])
    np.savetxt(tmp_path / "drive.csv", table, delimiter=",", header=header, comments="")
    return tmp_path


def test_a_newcomer_rehearses_a_robot_on_a_recording(desk):
    options = ["--onsets", "8", "--known-after", "40ms", "--kind", "locked", "--kind", "confined", "--kind", "one-way-"]
    answer = run_command("rehearse", "panda.urdf", "drive.csv", *options)
    assert answer.code == 0, answer.err
    assert "The arm survives" in answer.out
    folder = desk / "out" / "drive"
    found = json.loads((folder / "rehearsal.json").read_text())
    assert found["failures"] == 7 * 8 * 3
    assert found["known_after"] == 0.04
    page = (folder / "rehearsal.html").read_text()
    assert found["verdict"].split(" (")[0] in page
    assert re.search(r"(src|href)=.http", page) is None
    cells = json.loads(gzip.decompress(base64.b64decode(re.search(r'id="cells">(.*?)</script>', page)[1])))
    assert len(cells) == found["failures"]
    for cell in (cells[3], cells[60], cells[150]):  # the commands do what the page says
        words = shlex.split(cell["command"])
        assert words[0] == "stillreach"
        again = json.loads(run_command(*words[1:], "--json", "--no-plot").out)
        shown = float(re.search(r", ([\d.e-]+) mm and [\d.e-]+ deg at the end", cell["what"])[1])
        assert 1000 * again["goal_distance"] == pytest.approx(shown, rel=6e-3)
        assert again["faults"][0]["joint"] == cell["joint"]


def test_other_laws_on_request(desk):
    some = ["rehearse", "panda.urdf", "drive.csv", "--onsets", "3", "--no-page", "--no-plot"]
    answer = run_command(*some, "--laws", "keep-direction,pseudoinverse", "--json")
    found = json.loads(answer.out)["laws"]
    scenario = sr.Recording.load(desk / "drive.csv", arm=sr.Arm.from_urdf(desk / "panda.urdf")).scenario()
    expected = sr.tolerance.rehearse(scenario, onsets=3, law=sr.KeepDirection()).share
    assert found["keep-direction"] == pytest.approx(expected)
    assert set(found) == {"keep-direction", "pseudoinverse"}
    assert "under keep-direction:" in run_command(*some, "--laws", "keep-direction").out


def test_the_share_decides_the_exit_code(desk):
    some = ["rehearse", "panda.urdf", "drive.csv", "--onsets", "4", "--no-page"]
    share = json.loads(run_command(*some, "--json").out)["share"]
    assert 0.0 < share < 1.0
    assert run_command(*some, "--require", f"{share - 1e-6}").code == 0
    assert run_command(*some, "--require", "1").code == 1
    assert not (desk / "out" / "drive" / "rehearsal.html").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["panda-elbow", "--tip", "x"], "--tip: got 'x', expected a recording behind the robot"),
        (["panda-elbow", "--kind", "lock"], "--kind: got 'lock', expected one of locked"),
        (["panda-elbow", "--kind", "derated=2"], "--kind derated fraction: got 2"),
        (["panda-elbow", "--known-after", "-1"], "--known-after: got '-1'"),
        (["panda-elbow", "--within", "5"], "--within: got '5'"),
        (["panda-elbow", "--joint", "j4"], "joint: got 'j4'"),
        (["panda-elbow", "no.csv"], "RECORDING: got no.csv, expected none: panda-elbow is a scenario"),
        (["panda", "no.csv"], "--recording: got 'no.csv'"),
        (["no.toml"], "no.toml"),
    ],
)
def test_options_that_are_wrong(desk, arguments, said):
    answer = run_command("rehearse", *arguments, "--no-page")
    assert answer.code == 2
    assert said in " ".join(answer.err.split())


def test_the_page_opens_in_a_browser_without_errors_and_requests(desk):
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    found = sr.tolerance.rehearse(RECORDED, kinds=["locked", "derated"], onsets=12, known_after=0.04)
    if find_spec("zarr"):
        sr.tolerance.survey_along(found, desk / "x.zarr", count=20)
    found.page(desk / "page.html", "--recording drive.csv --robot panda.urdf")
    errors, requests = [], []
    with playwright.sync_playwright() as library:
        browser = chromium(library)
        page = browser.new_page()
        page.on("console", lambda message: errors.append(message.text))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto((desk / "page.html").as_uri())
        assert page.locator(".verdict").inner_text() == found.verdict
        page.locator("rect.cell").nth(5).click()
        assert page.locator("#case-command").inner_text().startswith("stillreach run --recording drive.csv")
        assert page.locator("rect.cell").count() == 7 * 12 * 2
        if found.survey is not None:  # the section "where it can still go", in light, dark and on a phone
            assert page.locator("h2", has_text="Where it can still go").is_visible()
            colours = set()
            for scheme in ("light", "dark"):
                page.emulate_media(color_scheme=scheme)
                colours.add(page.evaluate("getComputedStyle(document.querySelector('.left .cells')).fill"))
            assert len(colours) == 2
            page.set_viewport_size({"width": 400, "height": 800})
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        browser.close()
    assert errors == []
    assert [url for url in requests if not url.startswith(("file:", "blob:", "data:"))] == []


def test_the_pictures_of_a_page_are_well_formed():
    found = sr.tolerance.rehearse(RECORDED, kinds=["locked"], onsets=6)
    for svg in re.findall(r"<svg.*?</svg>", found.html(), re.DOTALL):
        ET.fromstring(svg)
    assert found.html().count("<figure>") == min(3, sum(found.when(which) != "never" for which in range(7)))
