"""The page in a real browser: what is done to it reaches the controller, whose state is what is asserted."""

import json
import os
import re
from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from stillreach.errors import PageNotBuiltError
from tests.browser import chromium

pytestmark = pytest.mark.xdist_group("browser")
SHARE = 1 if os.environ.get("STILLREACH_FULL") else 0.02
STATE = """() => {
  const { latest, frames, mode } = stillreach.viewer;
  const plain = ([name, value]) => [name, ArrayBuffer.isView(value) ? Array.from(value) : value];
  const lists = Object.fromEntries(Object.entries(latest).map(plain));
  return { ...lists, frames, mode };
}"""


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    with playwright.sync_playwright() as library:
        opened = chromium(library)
        yield opened
        opened.close()


class Opened:
    """A page from a file, and everything that it said and asked for."""

    def __init__(self, browser, path, **settings):
        self.tab = browser.new_page(**settings)
        self.said, self.asked = [], []
        self.tab.on("console", lambda message: self.said.append(message.text))
        self.tab.on("pageerror", lambda error: self.said.append(str(error)))
        self.tab.on("request", lambda request: self.asked.append(request.url))
        self.tab.goto(path)
        self.tab.evaluate("() => stillreach.ready.then(() => 1)")
        self.wait("stillreach.viewer.frames > 3 && stillreach.viewer.latest")

    def wait(self, condition):
        self.tab.wait_for_function(f"() => {condition}", timeout=20_000)

    @property
    def state(self):
        return self.tab.evaluate(STATE)

    def later(self, seconds=0.3):
        """The state so much time of the arm later."""
        now = self.state["time"]
        self.wait(f"stillreach.viewer.latest.time > {now + seconds}")
        return self.state

    def close(self):
        assert self.said == []
        assert [url for url in self.asked if not url.startswith(("file:", "blob:", "data:"))] == []
        self.tab.close()


@pytest.fixture
def opened(browser, tmp_path):
    pages = []

    def show(made, **settings):
        made.save(tmp_path / "page.html")
        pages.append(Opened(browser, (tmp_path / "page.html").as_uri() + settings.pop("query", ""), **settings))
        return pages[-1]

    yield show
    for page in pages:
        page.close()


def page_of(what):
    try:
        return what.page()
    except PageNotBuiltError as missing:
        pytest.skip(str(missing))


def still_where_it_broke(page, joint):
    """A locked joint has the rate 0 and does not move, and the tool goes on within its tolerance."""
    page.wait(f"stillreach.viewer.latest.known[{joint}] === 1")
    before, after = page.state, page.later()
    for state in (before, after):
        assert state["rates"][joint] == 0.0
        assert state["off"][0] < 0.02
    assert after["q"][joint] == before["q"][joint]
    assert np.count_nonzero(np.array(after["rates"])) > len(after["rates"]) // 2  # one may just stand at a limit


@pytest.mark.parametrize("query", ["", "?flat"])
def test_a_click_on_a_joint_and_on_the_list_each_lock_it(opened, query):
    page = opened(page_of(sr.arms.snake(9)), query=query)
    kind = page.tab.evaluate("() => stillreach.viewer.scene.turns === undefined")
    assert kind == (query == "")
    page.tab.mouse.click(*page.tab.evaluate("() => stillreach.viewer.pixel(4)"))
    still_where_it_broke(page, 4)
    page.tab.locator("button.joint").nth(2).click()
    still_where_it_broke(page, 2)
    assert "locked" in page.tab.locator(".status").inner_text()
    page.tab.locator("button.joint").nth(4).click()
    page.wait("stillreach.viewer.latest.known[4] === 0")
    assert page.later()["rates"][4] != 0.0


def test_every_joint_can_be_hit_in_the_scene(opened):
    """Joints 1 and 2, and 5 and 6, of a Panda share a point."""
    page = opened(page_of(sr.arms.panda()))
    page.tab.locator("button.play").click()
    page.wait("stillreach.viewer.latest.running === false")
    assert None not in page.tab.evaluate("() => [0, 1, 2, 3, 4, 5, 6].map((i) => stillreach.viewer.pixel(i))")
    page.tab.mouse.click(*page.tab.evaluate("() => stillreach.viewer.pixel(1)"))
    page.wait("stillreach.viewer.latest.known[1] === 1")
    assert sum(page.state["health"]) == 1


def test_the_controls_reach_the_controller(opened):
    page = opened(page_of(sr.arms.snake(9)))  # without acceleration limits: the rate limits alone are the bounds
    tab, limit = page.tab, sr.arms.snake(9).velocity_limits
    np.testing.assert_array_equal(page.state["upper"], limit)
    tab.locator("label.limits input").fill("0.1")
    page.wait(f"stillreach.viewer.latest.upper[0] < {0.5 * limit[0]}")
    np.testing.assert_allclose(page.state["upper"], 0.1 * limit, rtol=1e-15)
    tab.locator("select.motion").select_option("eight")
    tab.locator("select.law").select_option(label="pseudoinverse")
    page.wait(f"stillreach.viewer.latest.status & {int(sr.Status.OVER_LIMIT)}")
    tab.locator("select.law").select_option(label="least-error")
    page.wait(f"!(stillreach.viewer.latest.status & {int(sr.Status.OVER_LIMIT)})")
    tab.locator("label.limits input").fill("1")
    page.later(0.5)
    tab.locator("select.motion").select_option("hold")
    page.wait("stillreach.viewer.latest.rates.every((rate) => Math.abs(rate) < 1e-3)")
    tab.locator("select.null").select_option(label="back to the start posture")
    page.wait("stillreach.viewer.latest.rates.some((rate) => Math.abs(rate) > 1e-3)")
    assert page.state["off"][0] < 1e-3
    tab.locator("button.play").click()
    page.wait("stillreach.viewer.latest.running === false")
    paused = page.state["tick"]
    tab.wait_for_timeout(200)
    assert page.state["tick"] == paused
    tab.locator("button.step").click()
    page.wait(f"stillreach.viewer.latest.tick === {paused + 1}")
    tab.locator("select.kind").select_option(label="derated: at 30 % of its speed")
    tab.locator("button.joint").nth(1).click()
    page.wait("stillreach.viewer.latest.health[1] === 2")
    tab.locator("button.reset").click()
    page.wait("stillreach.viewer.latest.tick === 0 && stillreach.viewer.latest.health[1] === 0")


def test_a_dragged_target_moves_where_the_pointer_goes_also_when_paused(opened):
    page = opened(page_of(sr.arms.snake(9)))
    page.tab.locator("button.play").click()
    page.wait("stillreach.viewer.latest.running === false")
    target = np.array(page.state["target"]).reshape(4, 4)[:3, 3]
    x, y = page.tab.evaluate(
        """() => {
          const { scene, latest, canvas } = stillreach.viewer, box = canvas.getBoundingClientRect();
          const [x, y] = scene.project([latest.target[3], latest.target[7], latest.target[11]]);
          return [box.left + x, box.top + y];
        }"""
    )
    page.tab.mouse.move(x, y)
    page.tab.mouse.down()
    page.tab.mouse.move(x, y + 40, steps=4)
    page.later(1.0)
    page.tab.mouse.up()
    moved = np.array(page.state["target"]).reshape(4, 4)[:3, 3] - target
    assert moved[2] < -0.02  # down, in the plane of the screen
    assert page.state["off"][0] < 0.01


def test_what_the_controller_does_not_know_is_said_and_restored(opened):
    page = opened(page_of(sr.arms.panda()))
    sentence = page.tab.locator(".status")
    page.tab.locator("section.joints input[type=range]").fill("8")  # never
    for joint in (1, 3, 4):
        page.tab.locator("button.joint").nth(joint).click()
        page.wait(f"stillreach.viewer.latest.health[{joint}] === 1")
    state = page.later()
    assert [state["known"][joint] for joint in (1, 3, 4)] == [0, 0, 0]
    assert state["lost"] == 2  # four joints work
    text = sentence.inner_text()
    assert "the controller does not know about panda_joint2, panda_joint4 and panda_joint5" in text
    assert "the tool has lost" in text
    assert "possible" not in text
    page.tab.locator("section.joints input[type=range]").fill("0")
    page.tab.locator("button.heal").click()
    page.tab.locator("button.joint").nth(3).click()
    page.wait("stillreach.viewer.latest.known[3] === 1")
    page.tab.locator("section.joints input[type=range]").fill("8")
    page.tab.locator("button.joint").nth(3).click()
    page.wait("stillreach.viewer.latest.health[3] === 0")
    page.later()
    assert "the controller takes panda_joint4 for broken" in sentence.inner_text()
    page.tab.locator("button.heal").click()
    page.wait("stillreach.viewer.latest.known[3] === 0")


def test_what_an_arm_never_had_is_not_lost(opened):
    page = opened(page_of(sr.arms.planar(3)))
    sentence = page.tab.locator(".status")
    page.wait("document.querySelector('.status').innerText.includes('in the 3 directions of this arm is possible')")
    page.tab.keyboard.press("1")
    page.wait("document.querySelector('.status').innerText.includes('the tool has lost')")
    assert sentence.inner_text().startswith("j1 locked; ")
    assert "along z" not in sentence.inner_text()
    assert page.tab.evaluate("() => stillreach.viewer.latest.signs.length") == 1


def test_a_joint_that_the_controller_takes_for_working_is_shown_as_it_stands(opened):
    page = opened(page_of(sr.arms.panda()))
    page.tab.locator("section.joints input[type=range]").fill("8")  # never
    page.tab.keyboard.press("Escape")
    page.tab.keyboard.press("2")
    page.wait("stillreach.viewer.latest.health[1] === 1")
    state = page.later()
    assert state["known"][1] == 0
    assert state["rates"][1] != 0.0
    assert state["moving"][1] == 0.0


def test_the_space_bar_pauses_after_a_click_on_a_control(opened):
    page = opened(page_of(sr.arms.panda()))
    for control in ("button.random", "button.heal", ".looks input >> nth=4", ".looks button"):
        page.tab.locator(control).click()
        page.tab.keyboard.press(" ")
        page.wait("!stillreach.viewer.playing")
        page.tab.keyboard.press(" ")
        page.wait("stillreach.viewer.playing")


def test_a_slow_arm_follows_the_circle_that_it_is_given(opened):
    page = opened(page_of(sr.arms.canadarm2()))
    state = page.later(2.0)
    assert state["off"][0] < 0.01
    page.tab.keyboard.press("r")
    page.wait("stillreach.viewer.latest.time < 1 && stillreach.viewer.motionKind === 'circle'")
    assert np.count_nonzero(page.later()["rates"]) > 3  # it draws its circle again


def test_a_planned_fault_comes_also_after_the_joint_was_broken_and_restored(opened):
    page = opened(page_of(sr.Scenario.load("panda-elbow")))
    page.tab.keyboard.press("4")
    page.wait("stillreach.viewer.latest.known[3] === 1")
    page.tab.keyboard.press("4")
    page.wait("stillreach.viewer.latest.known[3] === 0")
    page.tab.evaluate("() => stillreach.viewer.setPace(10)")
    page.wait("stillreach.viewer.latest.time > 2.1")
    assert page.state["health"][3] == page.state["known"][3] == 1


def test_keys_alone(opened):
    page = opened(page_of(sr.arms.panda()))
    page.tab.keyboard.press("5")
    still_where_it_broke(page, 4)
    page.tab.keyboard.press("h")
    page.wait("stillreach.viewer.latest.known[4] === 0")
    page.tab.keyboard.press(" ")
    page.wait("!stillreach.viewer.playing")
    page.tab.keyboard.press("r")
    page.wait("stillreach.viewer.latest.tick === 0")
    page.tab.keyboard.press("s")
    page.wait("stillreach.viewer.latest.tick === 1")
    reached = set()
    for _ in range(40):
        page.tab.keyboard.press("Tab")
        reached.add(page.tab.evaluate("() => document.activeElement.className || document.activeElement.tagName"))
    assert {"joint", "play", "kind", "law", "motion", "scene"} <= reached


def test_a_run_is_replayed_and_gone_on_from(opened):
    scenario = sr.Scenario.load("panda-elbow")
    run = sr.simulate(scenario, progress=False)
    page = opened(page_of(run))
    assert page.state["mode"] == "replay"
    page.tab.locator("input.time").fill("3")
    page.wait("stillreach.viewer.latest.tick === 300")
    np.testing.assert_allclose(page.state["q"], run.q[300], atol=1e-6)
    assert page.state["health"] == run.health[300].tolist()
    page.tab.locator("button.go-on").click()
    page.wait("stillreach.viewer.mode === 'live' && stillreach.viewer.latest.tick > 310")
    state = page.state
    assert state["known"][3] == 1
    tick = min(state["tick"], scenario.steps)
    # a new controller, which has just heard of the fault: its spare freedom begins anew
    np.testing.assert_allclose(state["q"], run.q[tick], atol=2e-3)
    assert state["off"][0] < 2e-3
    page.tab.locator("button.back").click()
    page.wait("stillreach.viewer.mode === 'replay'")


def test_a_cell_of_a_rehearsal_is_played_to_the_error_that_is_stored(opened):
    found = sr.tolerance.rehearse(
        sr.Scenario.load("panda-elbow"), kinds=["locked"], onsets=[0.5, 1.0], known_after=0.03
    )
    page_of(sr.arms.panda())  # is there a program to play it?
    page = opened(type("Made", (), {"save": staticmethod(found.page)}))
    page.tab.evaluate("() => stillreach.viewer.send('speed', { value: 20 })")
    page.tab.locator("rect.cell").nth(0).click()
    page.wait("document.getElementById('case-played').textContent.startsWith('Played here: up to')")
    distance, angle = re.search(
        r"up to ([\d.e+-]+) mm and ([\d.e+-]+) deg off", page.tab.locator("#case-what").inner_text()
    ).groups()
    played = page.tab.locator("#case-played").inner_text()
    assert re.fullmatch(r"Played here: up to ([\d.e+-]+) mm and ([\d.e+-]+) deg off\.", played)
    numbers = list(map(float, re.findall(r"[\d.]+(?:e[+-]\d+)?(?= )", played)))
    np.testing.assert_allclose(numbers, [float(distance), float(angle)], rtol=6e-3)


def test_of_two_runs_each_goes_on_with_its_own_law_and_faults(opened):
    scenario = sr.Scenario.load("panda-elbow")
    other = replace(scenario, law=sr.KeepDirection(), faults=[sr.Fault("panda_joint2", at=1.0)])
    runs = [sr.simulate(task, progress=False) for task in (scenario, other)]
    try:
        page = opened(runs[0].page(runs[1]))
    except PageNotBuiltError as missing:
        pytest.skip(str(missing))
    options = page.tab.locator("select.run option").all_inner_texts()
    assert options == ["1: least-error, panda_joint4 locked", "2: keep-direction, panda_joint2 locked"]
    page.tab.locator("select.run").select_option(index=1)
    assert page.tab.locator("select.law option").first.inner_text() == "keep-direction"
    page.tab.locator("input.time").fill("0.5")
    page.tab.locator("button.go-on").click()
    page.wait("stillreach.viewer.latest.tick > 230")
    assert page.state["known"] == [0, 1, 0, 0, 0, 0, 0]
    state = page.state
    np.testing.assert_allclose(state["q"], runs[1].q[min(state["tick"], scenario.steps)], atol=5e-3)
    assert page.tab.locator("input.time").is_hidden()
    page.tab.locator("button.back").click()
    page.tab.locator("input.time").fill("3")
    page.wait("stillreach.viewer.mode === 'replay' && stillreach.viewer.latest.tick === 300")
    assert page.tab.evaluate("() => stillreach.viewer.plots[0].lines.length") == 3
    page.tab.locator("button.reset").click()
    assert page.tab.locator("input.time").input_value() == "0"
    page.tab.locator("input.time").fill("3")
    page.tab.locator("button.heal").click()
    page.wait("stillreach.viewer.mode === 'live' && stillreach.viewer.latest.known[1] === 0")


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (1920, 1080), (390, 844)])
def test_nothing_overflows_or_overlaps(opened, width, height):
    run = sr.simulate(sr.Scenario.load("panda-elbow"), progress=False)
    page = opened(page_of(run), viewport={"width": width, "height": height})
    wide, covered = page.tab.evaluate(
        """() => {
          const parts = [...document.querySelectorAll("header, .stage, .transport, .plots, .panel")];
          const boxes = parts.map((part) => part.getBoundingClientRect());
          const across = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1;
          const along = (a, b) => Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
          const covered = boxes.filter((a, i) => boxes.some((b, j) => i < j && across(a, b) && along(a, b)));
          return [document.documentElement.scrollWidth, covered.length];
        }"""
    )
    assert wide <= width
    assert covered == 0


def test_in_a_notebook_it_runs_in_a_frame(browser, tmp_path):
    shown = json.dumps(page_of(sr.arms.panda())._repr_html_()).replace("</", "<\\/")
    notebook = tmp_path / "notebook.html"
    notebook.write_text(f"<!doctype html><body></body><script>document.body.innerHTML = {shown}</script>")
    tab = browser.new_page()
    said = []
    tab.on("console", lambda message: said.append(message.text))
    tab.goto(notebook.as_uri())
    inner = tab.frames[1]
    inner.wait_for_function("() => window.stillreach?.viewer?.latest?.tick > 10", timeout=20_000)
    inner.locator("button.joint").nth(3).click()
    inner.wait_for_function("() => stillreach.viewer.latest.known[3] === 1", timeout=20_000)
    assert said == []
    tab.close()


class Heaps:
    """Bytes in use in the page and in its worker after a collection of garbage."""

    def __init__(self, tab):
        self.tab, self.session = tab, tab.context.new_cdp_session(tab)
        self.workers, self.answers = [], {}
        self.session.on("Target.attachedToTarget", lambda event: self.workers.append(event["sessionId"]))
        self.session.on("Target.receivedMessageFromTarget", lambda event: self.heard(json.loads(event["message"])))
        self.session.send(
            "Target.setAutoAttach", {"autoAttach": True, "waitForDebuggerOnStart": False, "flatten": False}
        )

    def heard(self, message):
        if "id" in message:
            self.answers[message["id"]] = message["result"]

    def ask(self, method):
        """The answers of page and worker."""
        (worker,), number = self.workers, len(self.answers) + 1
        text = json.dumps({"id": number, "method": method})
        self.session.send("Target.sendMessageToTarget", {"sessionId": worker, "message": text})
        there = self.session.send(method)
        while number not in self.answers:
            self.tab.wait_for_timeout(10)
        return there, self.answers[number]

    def used(self):
        """While the page stands still, so that no frame is on its way."""
        self.tab.evaluate("() => stillreach.viewer.run(false)")
        self.tab.wait_for_function("() => stillreach.viewer.latest.running === false")
        self.ask("HeapProfiler.collectGarbage")
        found = [heap["usedSize"] for heap in self.ask("Runtime.getHeapUsage")]
        self.tab.evaluate("() => stillreach.viewer.run(true)")
        return found


@pytest.mark.timeout(900)
def test_an_hour_at_full_speed_keeps_its_memory(opened):
    """3.6 million ticks and 5,000 frames with STILLREACH_FULL=1, a fiftieth of both without."""
    page = opened(page_of(sr.arms.panda()))
    ticks, frames = 3_600_000 * SHARE, 5_000 * SHARE
    heaps = Heaps(page.tab)
    page.tab.evaluate("() => stillreach.viewer.send('speed', { value: 4000 })")
    used, memory = [], set()
    for part in range(1, 11):
        made = f"latest.tick > {part * ticks / 10} && frames > {part * frames / 10}"
        page.tab.wait_for_function(
            f"() => {{ const {{ latest, frames }} = stillreach.viewer; return {made} }}", timeout=600_000
        )
        used.append(heaps.used())
        memory.add(page.state["memory"])
    assert len(memory) == 1
    print("bytes of page and worker after each tenth:", used)
    for before, after in zip(used[1], used[-1], strict=True):
        assert after < 1.05 * before + (0 if SHARE == 1 else 3_000_000)  # in a short one the plots still fill
