"""One scenario under several laws."""

from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation import comparison
from tests.unit.simulation.scenarios import first_ticks

FAULTS = [sr.Fault("j2", at=0.5)]
SCENARIO = sr.Scenario(
    arm=sr.arms.planar(4).with_limits(velocity=0.1),
    start=[0.2, 0.5, -0.4, 0.7],
    motion=sr.ConstantTwist([0.3, -0.4, 0, 0, 0, 0], duration=1.0),
    task=sr.Task(rows=[True, True, False, False, False, False]),
    faults=FAULTS,
    name="slow joints",
)


def test_each_law_runs_the_scenario_as_it_would_alone():
    laws = [sr.LeastError(), sr.KeepDirection(), sr.Pseudoinverse()]
    found = sr.compare(SCENARIO, laws, allowed_distance=10.0)
    assert list(found) == ["LeastError", "KeepDirection", "Pseudoinverse"]
    assert not found.interrupted
    for law, run in zip(laws, found.values(), strict=True):
        alone = sr.simulate(replace(SCENARIO, law=law))
        assert all(np.array_equal(array, run.arrays()[name]) for name, array in alone.arrays().items())
        assert found.summaries[type(law).__name__].goal_distance == alone.summary().goal_distance
        assert found.summaries[type(law).__name__].finished


def test_laws_of_one_class_have_names():
    found = sr.compare(SCENARIO, {"cheap": sr.LeastError(price=1), "dear": sr.LeastError(price=100)})
    assert found["cheap"].scenario.law.price == 1.0
    assert np.max(found["cheap"].task_error) > np.max(found["dear"].task_error)


def test_it_is_a_table_in_words():
    lines = str(sr.compare(SCENARIO, [sr.LeastError(), sr.Pseudoinverse()])).splitlines()
    assert lines[0] == "slow joints"
    assert lines[1].split() == ["law", "arrived", "ends", "off", "by", "farthest", "off", "peak", "rate"]
    assert lines[2].startswith("LeastError     NO ")
    assert lines[3].startswith("Pseudoinverse  yes ")
    assert "           above 100 %: drives cannot follow" in lines
    assert lines[-1].startswith("LeastError: from ")


@pytest.mark.parametrize(
    "laws", [[], sr.LeastError(), [sr.LeastError(), sr.LeastError(price=1)], ["least-error"], 3, {"one": None}]
)
def test_other_things_than_laws_are_refused(laws):
    with pytest.raises(sr.InputError, match=r"^laws: "):
        sr.compare(SCENARIO, laws)


@pytest.mark.parametrize("ticks", [0, 30])
def test_ctrl_c_keeps_what_was_computed(monkeypatch, ticks):
    """The interrupt itself is that of simulate, which has a test of its own."""
    run = sr.simulate

    def interrupted(scenario, **settings):
        if isinstance(scenario.law, sr.Pseudoinverse):
            raise sr.errors.SimulationInterrupted(first_ticks(run(scenario), ticks))
        return run(scenario)

    monkeypatch.setattr(comparison, "simulate", interrupted)
    with pytest.raises(sr.errors.SimulationInterrupted) as stopped:
        sr.compare(SCENARIO, [sr.LeastError(), sr.Pseudoinverse(), sr.KeepDirection()])
    kept = stopped.value.run
    assert [len(one) for one in kept.values()] == [101, 30][: 1 + (ticks > 0)]
    assert kept.interrupted is (ticks > 0)
    assert ("broken off" in str(kept)) is (ticks > 0)
