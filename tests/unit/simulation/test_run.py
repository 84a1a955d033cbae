import dataclasses
import json
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest

import stillreach as sr
from stillreach._core import RECORDED
from stillreach.simulation import simulator
from stillreach.simulation.document import scenario_text
from stillreach.simulation.record import FIELDS, Record, empty_record
from tests.refusals import refused
from tests.unit.simulation.scenarios import first_ticks, small_run

NAMES = [field.name for field in FIELDS]
MARK = 85
"""Every byte of an array, before a simulation."""


def assert_same(one, other):
    """Every array with its type, and the scenario in all its settings."""
    for name in NAMES:
        a, b = getattr(one, name), getattr(other, name)
        assert a.dtype == b.dtype, name
        assert np.array_equal(a, b), name
    assert (one.joint_names, one.joint_units) == (other.joint_names, other.joint_units)
    assert scenario_text(one.scenario) == scenario_text(other.scenario)
    assert one.interrupted == other.interrupted


def test_the_arrays_are_those_of_the_design():
    run = small_run()
    shapes = {
        "time": (31,),
        "path_time": (31,),
        "q": (31, 8),
        "measured": (31, 8),
        "rates": (31, 8),
        "pose": (31, 4, 4),
        "target": (31, 4, 4),
        "command": (31, 6),
        "residual": (31, 6),
    }
    shapes |= {"task_error": (31,), "damping": (31,), "scale": (31,), "status": (31,)}
    shapes |= {"lower": (31, 8), "upper": (31, 8), "health": (31, 8), "known": (31, 8), "active": (31, 8)}
    assert {name: getattr(run, name).shape for name in shapes} == shapes
    assert set(NAMES) == set(shapes)
    assert set(run.joint_units) == {"rad", "m"}


@pytest.mark.parametrize(
    "plant", [None, sr.plants.KinematicPlant(lag=0.02), sr.plants.MujocoPlant()], ids=lambda plant: type(plant).__name__
)
def test_every_array_of_every_tick_is_written(plant, monkeypatch):
    if isinstance(plant, sr.plants.MujocoPlant):
        pytest.importorskip("mujoco", reason="pip install 'stillreach[mujoco]'")

    def marked(ticks, joints):
        record = empty_record(ticks, joints)
        for array in record.values():
            array.view(np.int8).fill(MARK)
        return record

    monkeypatch.setattr(simulator, "empty_record", marked)
    arrays = small_run(plant=plant).arrays()
    assert [
        name for name, array in arrays.items() if np.any(array == np.full(8, MARK, np.int8).view(array.dtype)[0])
    ] == []


def test_every_array_that_the_core_records_has_its_place_in_a_run():
    assert sorted({*RECORDED} - {*NAMES}) == []


@pytest.mark.parametrize("name", NAMES)
def test_the_reference_says_what_an_array_is(name):
    assert re.search(rf"^ +(\w+, )*{name}(, \w+)*: \(T", Record.__doc__, re.MULTILINE)


def test_a_saved_run_comes_back_whole(tmp_path):
    run = small_run()
    run.save(tmp_path / "run.nc")
    assert_same(sr.Run.load(tmp_path / "run.nc"), run)


def test_infinite_bounds_and_an_empty_run_come_back_too(tmp_path):
    run = small_run(velocity_limits=np.inf, law=sr.Pseudoinverse(), faults=())
    empty = dataclasses.replace(run, **{name: getattr(run, name)[:0] for name in NAMES})
    for k, one in enumerate((run, empty)):
        one.save(tmp_path / f"{k}.nc")
        assert_same(sr.Run.load(tmp_path / f"{k}.nc"), one)


def test_the_file_says_what_its_numbers_are(tmp_path):
    import xarray

    small_run().save(str(tmp_path / "run.nc"))
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as data:
        assert all("units" in data[name].attrs and "long_name" in data[name].attrs for name in NAMES)
        assert data["time"].dtype == float
        assert data["rates"].dims == ("time", "joint")
        assert set(data["rates"].attrs["units"].split(", ")) == {"m/s", "rad/s"}
        assert data["component"].values.tolist() == ["vx", "vy", "vz", "wx", "wy", "wz"]
        assert data["health"].attrs["flag_meanings"] == " ".join(state.name.lower() for state in sr.Health)
        active = data["active"].attrs
        meaning = dict(zip(active["flag_values"].tolist(), active["flag_meanings"].split(), strict=True))
        assert (meaning[0], meaning[3], meaning[-2]) == ("free", "position_upper", "rate_lower")
        masks = dict(
            zip(data["status"].attrs["flag_meanings"].split(), data["status"].attrs["flag_masks"], strict=True)
        )
        assert masks["DAMPED"] == sr.Status.DAMPED
        assert (data.attrs["title"], data.attrs["interrupted"]) == ("a small run", 0)
        assert json.loads(data["scenario"].item())["law"]["kind"] == "singularity-robust"


def test_one_joint_is_picked_by_name(tmp_path):
    run = small_run()
    data = run.to_xarray()
    np.testing.assert_array_equal(data["rates"].sel(joint="j3"), run.rates[:, 2])


def test_a_run_cannot_be_changed():
    run = small_run()
    with pytest.raises(ValueError, match="read-only"):
        run.rates[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.rates = run.q
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.scenario.period = 1.0


def test_a_run_survives_pickling():
    run = small_run()
    copy = pickle.loads(pickle.dumps(run))
    assert_same(copy, run)
    assert not copy.q.flags.writeable


def test_arrays_that_do_not_fit_are_refused_by_name():
    run = small_run()
    with refused("rates", "(31, 7)", "(31, 8)"):
        dataclasses.replace(run, rates=run.rates[:, :7])
    with refused("time", "31", "21"):
        dataclasses.replace(run, scenario=dataclasses.replace(run.scenario, duration=1.0))


def test_a_file_that_is_no_run_is_refused(tmp_path):
    (tmp_path / "text.nc").write_text("not a netCDF file")
    with pytest.raises(sr.InputError, match=r"text\.nc"):
        sr.Run.load(tmp_path / "text.nc")
    small_run().to_xarray().drop_vars(["damping", "health"]).to_netcdf(tmp_path / "part.nc", engine="h5netcdf")
    with refused("path", "damping, health"):
        sr.Run.load(tmp_path / "part.nc")
    with pytest.raises(FileNotFoundError, match=r"nothing\.nc"):
        sr.Run.load(tmp_path / "nothing.nc")


@pytest.mark.parametrize(
    ("package", "call", "extra"),
    [
        ("h5py", "run.save('x.nc')", "netcdf"),
        ("xarray", "run.to_xarray()", "netcdf"),
        ("matplotlib", "run.plot()", "plot"),
    ],
)
def test_a_missing_package_is_answered_with_the_command_that_installs_it(package, call, extra):
    code = (
        f"import sys; sys.modules[{package!r}] = None\n"
        "import numpy as np, stillreach as sr\n"
        "twist = sr.ConstantTwist(np.zeros(6), 0.02)\n"
        "run = sr.simulate(sr.Scenario(arm=sr.arms.planar(3), start=np.ones(3), motion=twist))\n"
        f"try:\n    {call}\nexcept sr.errors.MissingExtraError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert f"pip install 'stillreach[{extra}]'" in done.stdout


def test_a_run_without_ticks_has_no_summary_and_no_picture():
    empty = first_ticks(small_run(), 0)
    for call in (empty.summary, empty.plot):
        with pytest.raises(sr.InputError, match="run: got no ticks"):
            call()


def test_a_run_tells_its_name_ticks_arm_and_law():
    run = small_run()
    assert repr(run) == "<Run 'a small run': 31 ticks of 50 ms, eight joints, SingularityRobust>"
    assert repr(first_ticks(run, 3)) == (
        "<Run 'a small run': 3 ticks of 50 ms, eight joints, SingularityRobust, interrupted>"
    )


@pytest.mark.parametrize("loop", ["open", "closed"])
@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("kind", ["twists", "course", "function"])
def test_how_far_off_its_target_the_tool_was_is_in_the_file(tmp_path, kind, integrator, loop):
    """The target of each tick, known by hand: steady along x, then at rest."""
    motions = {
        "twists": sr.ConstantTwist([-0.1, 0, 0, 0, 0, 0.2], duration=1.0),
        "course": sr.Line(to=[-0.1, 0, 0], relative=True, duration=1.0, profile="constant"),
        "function": lambda t: [-0.1, 0, 0, 0, 0, 0.2] if t < 1.0 else [0.0] * 6,
    }
    start = np.deg2rad([0, 20, -60, 100, -60, 30, 0])
    scenario = sr.Scenario(
        arm=sr.arms.canadarm2().with_limits(velocity=1.0),
        start=start,
        motion=motions[kind],
        duration=1.5,
        period=0.05,
        loop=loop,
        integrator=integrator,
        faults=[sr.Fault("j2", at=0.5)],
    )
    sr.simulate(scenario).save(tmp_path / "run.nc")
    run = sr.Run.load(tmp_path / "run.nc")
    T, moved = scenario.arm.forward(start), np.minimum(run.time, 1.0)
    np.testing.assert_allclose(run.target[:, :3, 3], T[:3, 3] + np.outer(moved, [-0.1, 0, 0]), atol=1e-9)
    angle = 0.0 * moved if kind == "course" else 0.2 * moved
    cosine, sine, zero, one = np.cos(angle), np.sin(angle), 0 * angle, 0 * angle + 1
    turn = np.array([[cosine, -sine, zero], [sine, cosine, zero], [zero, zero, one]]).transpose(2, 0, 1)
    np.testing.assert_allclose(run.target[:, :3, :3], turn @ T[:3, :3], atol=1e-9)


def test_active_bounds_are_those_of_the_ticks():
    """Tick by tick with a Controller beside the run."""
    arm = sr.arms.planar(3).with_limits(velocity=0.4, position=[(-3, 0.5), (-3, 3), (-3, 3)], acceleration=2.0)
    scenario = sr.Scenario(
        arm=arm,
        start=[0.3, 0.9, -0.8],
        motion=sr.ConstantTwist([-0.5, 0.4, 0, 0, 0, 0], duration=1.0),
        task=sr.Task(rows=(True, True, False, False, False, False)),
        faults=[sr.Fault(1, at=0.3), sr.Fault(2, at=0.6, kind=sr.Derated(0.5))],
    )
    run, ctl = sr.simulate(scenario), scenario.controller()
    for tick in range(len(run) - 1):
        if tick == 30:
            ctl.fail(1)
        if tick == 60:
            ctl.fail(2, sr.Derated(0.5))
        assert np.array_equal(ctl.step(run.q[tick], run.command[tick]).active, run.active[tick])
    seen = set(np.abs(run.active).ravel().tolist())
    assert {sr.Reason.FREE, sr.Reason.FAULT, sr.Reason.RATE, sr.Reason.ACCELERATION} <= seen
