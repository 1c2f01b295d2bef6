"""The smooth route recovers blind plants from far starts, and says what smoothing did."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from diagnosis.blindtest.plants import integrate
from identification.experiment import Experiment, experiment_of
from identification.fit import measured
from identification.problem import Problem
from identification.smooth_fit import SmoothFit, fit_smooth
from identification.smooth_fit.guess import guessed
from identification.smooth_fit.residuals import SmoothResiduals
from identification.unknowns import base_unknowns, effect_unknowns, start_unknown
from valvemodel.model import Model
from valvemodel.records import Record, write_table
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

NOISE = 1e-4
FREE = ("spring_rate", "coulomb_friction", "viscous_friction", "gap_offset", "gap_gain")


def calibrated(**changes: float) -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, {**valve.values, **changes})


def profile(seconds: float = 40.0, rate: float = 50.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A triangle, then steps. [s], [A]"""
    time = np.arange(int(seconds * rate)) / rate
    triangle = np.interp(time % 20.0, [0.0, 10.0, 20.0], [5e-3, 19e-3, 5e-3])
    steps = np.repeat(np.random.default_rng(seed).uniform(5e-3, 19e-3, len(time) // 40 + 1), 40)[: len(time)]
    return time, np.where(time < 0.5 * seconds, triangle, steps)


def blind_record(seed: int = 0, **arguments: float) -> Record:
    """Readings of the calibrated valve by the plants' own integration, with noise."""
    time, current = profile(**arguments)
    values = {name: value for name, value in calibrated().values.items() if np.isfinite(value)}
    position = integrate(values, time, current, step=2e-5)["position"]
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(time))
    return Record.from_arrays(name="plant", time=time, current=current, position=position + noise)


def record_of(model: Model, seed: int = 0, **arguments: float) -> Record:
    time, current = profile(**arguments)
    trajectory = simulate(model, time=time, current=current)
    noise = np.random.default_rng(seed).standard_normal((2, len(time)))
    return Record.from_arrays(
        name="record",
        time=time,
        current=current,
        position=trajectory.position + NOISE * noise[0],
        pressure=trajectory.pressure + 200.0 * noise[1],
    )


def far_start(seed: int) -> Model:
    generator = np.random.default_rng(seed)
    values = calibrated().values
    return calibrated(**{name: values[name] * 2.0 ** generator.uniform(-1.0, 1.0) for name in FREE})


def problem_of(model: Model, experiments: list[Experiment]) -> Problem:
    unknowns = base_unknowns(model)
    for key, values in model.effects.items():
        unknowns += effect_unknowns(key, dict(values))
    unknowns += [start_unknown(each.first_reading, number) for number, each in enumerate(experiments)]
    return Problem(model, experiments, unknowns, measured(experiments))


@pytest.fixture(scope="module")
def fitted() -> SmoothFit:
    return fit_smooth([experiment_of(blind_record(seconds=20.0))], far_start(3))


def test_a_blind_plant_is_recovered_from_a_far_start(fitted: SmoothFit):
    truth = calibrated().values
    for name in FREE:
        assert fitted.fit.model.values[name] == pytest.approx(truth[name], rel=2e-2), name
        assert fitted.smooth.model.values[name] == pytest.approx(truth[name], rel=2e-2), name


def test_smoothing_moves_the_fit_less_the_narrower_it_is(fitted: SmoothFit):
    widths = [each.width for each in fitted.smoothing]
    assert widths == sorted(widths, reverse=True)
    for measure in (lambda each: each.rms, lambda each: each.largest, lambda each: abs(each.shifts["spring_rate"])):
        amounts = [measure(each) for each in fitted.smoothing]
        assert amounts == sorted(amounts, reverse=True)
    last = fitted.smoothing[-1]
    assert last.largest < 3e-5
    for name in FREE:
        assert abs(last.shifts[name]) < 2e-3 * fitted.fit.model.values[name], name


def test_the_guess_does_not_hang_on_the_start():
    experiments = [experiment_of(record_of(calibrated()))]
    values = []
    for seed in range(4):
        problem = problem_of(far_start(seed), experiments)
        values.append(problem.values(guessed(problem)))
    for name in ("spring_rate", "gap_offset", "gap_gain"):
        assert np.ptp([each[name] for each in values]) < 0.15 * values[0][name]
        assert values[0][name] == pytest.approx(calibrated().values[name], rel=0.7)


@pytest.mark.parametrize("key", [None, "coil_lag", "transport_delay", "linkage_backlash", "asymmetric_friction"])
def test_derivatives_of_the_residuals_agree_with_differences(key):
    model = calibrated() if key is None else calibrated().with_effect(key)
    problem = problem_of(model, [experiment_of(record_of(model, seconds=8.0))])
    residuals = SmoothResiduals(problem)
    point = np.random.default_rng(0).uniform(-0.05, 0.05, len(problem.unknowns))
    jacobian = residuals.jacobian(point, 50.0)
    for column in range(len(point)):
        step = np.zeros(len(point))
        step[column] = 1e-6
        change = (residuals.residuals(point + step, 50.0) - residuals.residuals(point - step, 50.0)) / 2e-6
        scale = np.abs(change).max()
        # A few samples stand at a kink, where differences say something else.
        assert np.quantile(np.abs(change - jacobian[:, column]), 0.98) < 1e-3 * scale, problem.unknowns[column].name


def test_several_records_share_parameters_and_the_pressure_counts():
    records = [record_of(calibrated(), seed=seed, seconds=10.0) for seed in range(2)]
    fitted = fit_smooth([experiment_of(record) for record in records], far_start(5), widths=(100.0, 1.0))
    assert len(fitted.fit.starts) == 2
    for name in FREE:
        assert fitted.smooth.model.values[name] == pytest.approx(calibrated().values[name], rel=1e-2), name


def test_multiple_shooting_ends_where_the_single_run_does():
    experiment = experiment_of(record_of(calibrated(), seconds=12.0))
    start = far_start(1)
    given = {"widths": (30.0,)}
    once = fit_smooth([experiment], start, **given).smooth
    often = fit_smooth([experiment], start, is_multiple=True, **given).smooth
    assert often.found.error == pytest.approx(once.found.error, rel=1e-4)
    for name in FREE:
        assert often.model.values[name] == pytest.approx(once.model.values[name], rel=1e-3), name


def test_a_swinging_stem_is_found_by_way_of_wide_smoothing():
    truth = calibrated(viscous_friction=1.59)
    fitted = fit_smooth(
        [experiment_of(record_of(truth, seconds=16.0, rate=100.0))], far_start(2).with_values(viscous_friction=3.0)
    )
    for name in FREE:
        assert fitted.smooth.model.values[name] == pytest.approx(truth.values[name], rel=2e-2), name


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("asymmetric_viscous_friction", {"viscous_asymmetry": 0.5}),
        ("coil_lag", {"coil_time_constant": 0.2}),
        ("transport_delay", {"transport_delay": 0.13}),
    ],
)
def test_an_effect_is_fitted_with_the_valve(key, values):
    truth = calibrated().with_effect(key, **values)
    time, current = profile(seconds=16.0)
    position = simulate(truth, time=time, current=current).position
    noise = NOISE * np.random.default_rng(2).standard_normal(len(time))
    record = Record.from_arrays(name="r", time=time, current=current, position=position + noise)
    fitted = fit_smooth([experiment_of(record)], calibrated(), effects=[key], widths=(30.0, 1.0))
    for name, value in values.items():
        # A delay is blurred by the samples between which a step's answer begins: half a period, and the noise.
        assert fitted.smooth.model.effects[key][name] == pytest.approx(value, rel=0.05, abs=0.011)


def test_command_writes_route_and_smoothing(tmp_path):
    from valvemodel.commands import command_line

    record = record_of(calibrated(), seconds=20.0)
    table = {"time [s]": record.time, "current [mA]": 1e3 * record.current, "position [mm]": 1e3 * record.position}
    write_table(tmp_path / "record.csv", table)
    arguments = ["fit", str(tmp_path / "record.csv"), "--route", "smooth", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(command_line, arguments)
    assert done.exit_code == 0, done.output
    content = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert content["route"] == "smooth"
    widths = [each["width"]["value"] for each in content["smoothing"]]
    assert widths == [1000.0, 100.0, 10.0, 1.0]
    shift = content["smoothing"][-1]["parameters"]["spring_rate"]
    assert shift["value"] - shift["shift"] == pytest.approx(content["parameters"]["spring_rate"]["value"])
    assert "smoothing" in done.output
