"""Every law, fault, null motion and motion is known wherever kinds are listed; one that is forgotten fails by name."""

import inspect
import re
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
import stillreach.cli
from stillreach._core import LawKind, NullMotionKind
from stillreach._formats import FORMATS
from stillreach._forms import Either, Flag, Number, Sign, Word
from stillreach._lists import List, PerJoint
from stillreach.cli._app import app
from stillreach.cli._complete import complete_law
from stillreach.cli._faults import parse_fault
from stillreach.cli._laws import parse_law
from stillreach.faults import FAULTS, FaultKind, Loses
from stillreach.laws import LAWS, Law
from stillreach.null_motions import NULL_MOTIONS, NullMotion
from stillreach.plants import PLANTS, Plant
from stillreach.show.style import HEALTH_COLOURS
from stillreach.simulation.course import Course
from stillreach.simulation.motion import MOTIONS
from stillreach.simulation.scenario_file.tables import SCENARIO, TASK, WEIGHTS
from tests.fuzzing.toml import written

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
SETS = {"law": LAWS, "faults": FAULTS, "null_motion": NULL_MOTIONS, "motion": MOTIONS, "plant": PLANTS}
ALL = list(chain.from_iterable(SETS.values()))
IN_FILES = [kind for kind in ALL if kind.in_files]
ARM = sr.arms.planar(3)
MORE = {"line": {"to": [1.0, 0.5, 0.0]}, "waypoints": {"duration": 1.0}, "twist": {"duration": 1.0}}
"""What a kind needs in a file beside its required settings."""


def sample(form):
    """A legal value of a form, as a file holds it."""
    if isinstance(form, Either):
        return sample(form.forms[0])
    if isinstance(form, Number):
        return 1 if isinstance(form, Sign) else 0.5
    if isinstance(form, Flag):
        return True
    if isinstance(form, Word):
        return form.words[0]
    if isinstance(form, List):
        return [sample(entry) for entry in form.forms]
    if isinstance(form, PerJoint):
        return [sample(form.entry)] * ARM.n
    return "poses.csv"


def settings(kind):
    required = {name: sample(own.form) for name, own in kind.keys().items() if own.default is inspect.Parameter.empty}
    return required | MORE.get(kind.word, {})


@pytest.fixture
def scenario(tmp_path):
    """A scenario from a file with one law, fault, null motion or motion."""

    def loaded(kind):
        key = next(key for key, kinds in SETS.items() if kind in kinds)
        table = {"kind": kind.word, **settings(kind)}
        content = {
            "start": [0.1, 0.5, 1.0],
            "robot": {"arm": "planar", "n": 3},
            "motion": [{"kind": "wait", "duration": 1}],
        }
        content |= {"faults": [{"joint": "j2", "at": 0.5, **table}]} if key == "faults" else {}
        content |= {key: [table] if key == "motion" else table} if key != "faults" else {}
        (tmp_path / "poses.csv").write_text("time,x,y,z\n0.5,1.5,1,0\n1,1,1,0\n")
        (tmp_path / "one.toml").write_text(written(content))
        return sr.Scenario.load(tmp_path / "one.toml")

    return loaded


def part(scenario, kind):
    """What a scenario has of the set that a kind belongs to."""
    if issubclass(kind, Law):
        return scenario.law
    if issubclass(kind, FaultKind):
        return scenario.faults[0].kind
    if issubclass(kind, Plant):
        return scenario.plant
    return scenario.null_motion if issubclass(kind, NullMotion) else scenario.motion[0]


@pytest.mark.parametrize("kind", IN_FILES, ids=lambda kind: kind.word)
def test_a_file_and_a_record_can_hold_it_and_it_runs(scenario, kind, tmp_path):
    loaded = scenario(kind)
    assert type(part(loaded, kind)) is kind
    run = sr.simulate(loaded, progress=False)
    assert np.isfinite(run.q).all()
    run.save(tmp_path / "run.npz")
    again = part(sr.Run.load(tmp_path / "run.npz").scenario, kind)
    assert type(again) is kind
    assert vars(again).keys() == vars(part(loaded, kind)).keys()


@pytest.mark.parametrize("base", [Law, FaultKind, NullMotion, Course, Plant])
def test_every_class_of_a_set_is_in_its_table(base):
    classes, found = [base], set()
    while classes:
        classes += (subclasses := classes.pop().__subclasses__())
        found |= {cls for cls in subclasses if cls.__module__.startswith("stillreach.")}
    assert {cls.__name__ for cls in found} <= {kind.__name__ for kind in ALL}


def test_words_are_words_and_no_two_are_the_same():
    assert len({kind.word for kind in ALL}) == len(ALL)
    assert all(re.fullmatch(r"[a-z]+(-[a-z]+)*", kind.word) for kind in ALL)


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.word)
def test_python_code_finds_it_by_name(kind):
    homes = {NullMotion: sr.null_motions, Plant: sr.plants}
    home = next((home for base, home in homes.items() if issubclass(kind, base)), sr)
    assert getattr(home, kind.__name__) is kind
    assert home is not sr or kind.__name__ in sr.__all__


@pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.word)
def test_the_reference_and_the_guides_name_it(kind):
    assert f".. autoclass:: {kind.__name__}\n" in (DOCS / "reference.md").read_text()
    if kind in NULL_MOTIONS:
        assert f"`{kind.__name__}(" in (DOCS / "controller.md").read_text()


@pytest.mark.parametrize("kind", IN_FILES, ids=lambda kind: kind.word)
def test_the_page_on_scenario_files_and_the_schema_hold_it_with_all_its_settings(kind):
    page = (DOCS / "scenarios.md").read_text(encoding="utf-8")
    assert f'`"{kind.word}"`' in page
    assert [name for name in list(kind.keys()) if f"`{name}`" not in page] == []
    table = sr.scenario_schema()["definitions"][kind.__name__]
    assert table["properties"]["kind"] == {"const": kind.word}
    assert table["properties"].keys() >= kind.keys().keys()


@pytest.mark.parametrize(
    ("table", "made"),
    [(SCENARIO, sr.Scenario), (TASK, sr.Task), (WEIGHTS, sr.Weights)],
    ids=["scenario", "task", "weights"],
)
def test_a_file_has_a_key_for_every_argument_and_no_others(table, made):
    arguments = {{"arm": "robot"}.get(name, name) for name in inspect.signature(made).parameters}
    assert sorted((table.keys.keys() - {"units"}) ^ arguments) == []


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.word)
def test_the_command_line_knows_every_law_and_the_batch_solves_it(law):
    assert complete_law(law.word)[0] == law.word
    assert parse_law(law.word) == law()
    q, twist = np.array([[0.1, 0.5, 1.0]] * 5), np.array([0.05, 0.0, 0.0, 0.0, 0.0, 0.0])
    task = sr.Task(rows="position")
    found = sr.solve_batch(ARM, law(), q, twist, sr.Bounds.symmetric(1.0, n=3), task=task)
    alone = sr.Controller(ARM, law=law(), task=task).step(q[0], twist)
    np.testing.assert_allclose(found.rates[4], alone.rates, atol=1e-12)


@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: kind.word)
def test_the_command_line_knows_every_fault_and_it_has_a_sentence(kind):
    values = ",".join(str(value) for value in settings(kind).values())
    fault = parse_fault(ARM, f"j2@0.5:{kind.word}{'=' * bool(values)}{values}")
    assert type(fault.kind) is kind
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")
    assert kind is FAULTS[0] or f":{kind.word}{'=' * bool(values)}" in page
    sentences = {fault.kind.sentence(slides=slides) for slides in (False, True)}
    assert all(text and kind.__name__ not in text for text in sentences)


@pytest.mark.parametrize("kind", FAULTS, ids=lambda kind: kind.word)
@pytest.mark.parametrize("rate", [-0.8, 0.8])
def test_what_a_fault_leaves_of_rates_and_positions_is_what_the_core_leaves(kind, rate):
    given = settings(kind) | {"confined": {"lower": -1.0, "upper": 2.0}}.get(kind.word, {})
    fault, spin = kind(**given), [0.0, 0.0, 0.0, 0.0, 0.0, rate]
    motion, task = sr.ConstantTwist(spin, duration=20.0), sr.Task(rows=[False] * 5 + [True])
    one = sr.arms.planar(1).with_limits(velocity=[1.0])
    faults = [sr.Fault(0, kind=fault)]
    run = sr.simulate(sr.Scenario(arm=one, start=[0.0], motion=motion, task=task, faults=faults), progress=False)
    told = fault.driven(rate, 1.0)
    assert run.rates[0, 0] == pytest.approx(told, abs=1e-12)
    wanted = rate if kind.loses in (Loses.RANGE, Loses.SIDE) else told
    assert run.q[-1, 0] == pytest.approx(np.clip(20.0 * wanted, *fault.positions(0.0)), abs=1e-6)


def test_every_member_of_the_core_has_one_class_and_every_health_a_colour():
    assert [kind.health for kind in FAULTS] == [health for health in sr.Health if health is not sr.Health.HEALTHY]
    assert {law.kind for law in LAWS} == set(LawKind)
    assert {kind.kind for kind in NULL_MOTIONS} == set(NullMotionKind) - {NullMotionKind.NONE}
    assert len(set(HEALTH_COLOURS.values())) == len(FAULTS)


@pytest.mark.parametrize(("name", "entry"), [("STATE_SIGN", r'"."'), ("HEALTH_COLOURS", r'"#\w{6}"')])
def test_the_live_page_has_a_sign_and_a_colour_for_every_health(name, entry):
    (text,) = re.findall(rf"^const {name} = \[(.*)\];", (ROOT / "page/src/viewer.js").read_text("utf-8"), re.M)
    assert len(set(re.findall(entry, text))) >= len(sr.Health)


def test_programs_in_c_plus_plus_and_ros_can_name_every_fault():
    front, forms = (
        (ROOT / "include/stillreach" / name).read_text("utf-8") for name in ("stillreach.hpp", "control/bounds.hpp")
    )
    assert [kind.word for kind in FAULTS if f"Health::{kind.health.name}" not in front] == []
    assert [kind.word for kind in FAULTS if f'{{"{kind.word}", Health::{kind.health.name}, ' not in forms] == []


def test_c_plus_plus_tests_and_instruction_counts_run_every_law():
    text = (ROOT / "tests/cpp/robot.hpp").read_text("utf-8")
    assert [law.word for law in LAWS if f"LawKind::{law.kind.name}" not in text] == []


def test_every_reader_of_robot_files_is_a_format():
    readers = {name.removeprefix("from_") for name in dir(sr.Arm) if name.startswith("from_")} - {"dh", "modules"}
    assert readers == FORMATS.keys()


def test_every_module_of_a_command_is_a_command_and_has_a_row_on_its_page():
    folder = Path(stillreach.cli.__file__).parent
    modules = {file.stem for file in folder.glob("[a-z]*.py")}
    assert {command.callback.__name__ for command in app.registered_commands} == modules
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")
    assert [name for name in sorted(modules) if f"| `stillreach {name}" not in page] == []


def test_scenario_files_leave_out_only_what_needs_a_python_function() -> None:
    """A class derived from Gradient would inherit that, and be missing from files without an error."""
    assert [kind.word for kind in ALL if not kind.in_files] == ["gradient"]
