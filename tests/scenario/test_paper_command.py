"""`stillreach paper` from end to end."""

import json
from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from stillreach.paper import examples
from stillreach.paper.figures import PICTURES
from tests.commands import run_command

RUNS = (
    "example-1-free",
    "example-1-failed",
    "example-2-free",
    "example-2-failed-pseudoinverse",
    "example-2-failed-closed-form",
    "example-2-failed-exact",
    "example-2-failed-stillreach",
)


def test_the_command_ends_well_and_every_statement_stands_as_documented(reproduction):
    assert reproduction.exit_code == 0, reproduction.printed
    assert "8 reproduced, 2 not reproduced, 1 refuted, 5 ours" in reproduction.printed
    assert "✗" not in reproduction.printed
    claims = json.loads((reproduction.folder / "claims.json").read_text())
    keys = {"id", "group", "statement", "paper", "measured", "unit", "holds", "as_documented"}
    assert all(set(claim) == keys for claim in claims)
    assert all(claim["as_documented"] is True for claim in claims)
    assert len({claim["id"] for claim in claims}) == len(claims) == 16


def test_every_figure_is_a_picture_and_stands_in_the_report(reproduction):
    report = (reproduction.folder / "report.md").read_text()
    names = [f"figure-{k:02}.png" for k in range(1, 13)]
    assert names == [picture.file for picture in PICTURES[:12]]
    for picture in PICTURES:
        image = (reproduction.folder / picture.file).read_bytes()
        assert image.startswith(b"\x89PNG")
        assert len(image) > 10_000
        assert f"]({picture.file})" in report
        assert picture.caption in report


def test_the_report_holds_every_claim_and_the_reading_notes(reproduction):
    report = (reproduction.folder / "report.md").read_text()
    for claim in json.loads((reproduction.folder / "claims.json").read_text()):
        assert claim["statement"] in report
    for heading in ("### Reproduced", "### Not reproduced", "### Refuted", "### Ours"):
        assert f"\n{heading}" in report
    for said in ("twelve letters", "12 entries", "Inferred", "(12)-(16)", "∞-norm", "all joints free", "561"):
        assert said in report


@pytest.mark.parametrize("name", RUNS)
def test_rates_stay_inside_the_limit_and_failed_joints_stand_still(reproduction, name):
    run = sr.Run.load(reproduction.folder / f"{name}.nc")
    if name == "example-2-failed-pseudoinverse":
        assert np.all(np.isinf(run.upper[run.health == 0]))
        assert np.all(np.isinf(run.scenario.velocity_limits))
        assert "without rate limit" in run.scenario.title
    else:
        assert np.max(np.abs(run.rates)) <= np.deg2rad(50.0)
        assert np.all((run.lower <= run.rates) & (run.rates <= run.upper))
    failed = {"example-1-failed": [0, 5, 6]}.get(name, [1, 3, 6] if "failed" in name else [])
    assert np.flatnonzero(run.health[0]).tolist() == failed
    assert np.all(run.rates[:, failed] == 0.0)
    assert np.all(run.q[:, failed] == run.q[0, failed])


def test_each_run_is_the_paper_s_twenty_seconds_in_steps_of_a_twentieth(reproduction):
    for name in RUNS:
        run = sr.Run.load(reproduction.folder / f"{name}.nc")
        period = 0.01 if name.endswith("stillreach") else 0.05
        np.testing.assert_allclose(run.time, np.arange(round(20 / period) + 1) * period, atol=1e-12)
        assert run.scenario.integrator == "euler"


def test_the_free_run_of_example_2_costs_less_than_the_default_price():
    """Its smallest singular value is 0.41, and its rates are a tenth of their limits."""
    scenario = examples.scenarios()[examples.EXAMPLE_2_FREE]
    rates = [
        sr.simulate(replace(scenario, task=sr.Task(), velocity_limits=np.deg2rad(50.0), law=law)).rates
        for law in (sr.LeastError(), sr.LeastError(price=None), sr.Pseudoinverse())
    ]
    np.testing.assert_allclose(rates[0], rates[1], atol=1e-9)
    np.testing.assert_allclose(rates[0], rates[2], atol=1e-9)


def test_step_duration_and_lengths_are_the_user_s(tmp_path):
    options = ["--step", "0.5", "--duration", "10", "--lengths", ",".join(["0.7"] * 6)]
    done = run_command("paper", "--out", tmp_path, *options)
    assert done.code == 1  # with another arm some statements stand otherwise
    assert "✗" in done.out
    run = sr.Run.load(tmp_path / "example-1-free.nc")
    assert len(run) == 21
    arm = sr.arms.nasa_modular(lengths=[0.7] * 6)
    np.testing.assert_allclose(run.pose, arm.forward(run.q), atol=1e-12)
    np.testing.assert_allclose(run.command[0, :3], np.array([-5.5, -2.5, 1.5]) * 0.0254, atol=1e-15)


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "taken").write_text("a file")
    done = run_command("paper", "--out", tmp_path / "taken")
    assert done.code == 2
    assert "taken" in done.err
    assert len(done.err.splitlines()) == 1


@pytest.mark.parametrize("option", [("--step", "0"), ("--step", "2"), ("--duration", "-1"), ("--lengths", "1,2,3")])
def test_an_option_that_cannot_be_is_refused_before_anything_is_computed(tmp_path, option):
    done = run_command("paper", "--out", tmp_path / "new", *option)
    assert done.code == 2
    assert option[0].strip("-") in done.err
    assert len(done.err.splitlines()) == 1
    assert not (tmp_path / "new").exists()
