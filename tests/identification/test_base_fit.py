"""The base fit finds the parameters of blind plants; noise, hints and uncertainty are honest."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from identification.determined.uncertainty import covariance, estimates
from identification.experiment import experiment_of
from identification.extending.extension import extend
from identification.fit import Fit, fit_base
from identification.noise import flicker_level, noise_level, reading_grid
from identification.starting.hints import coarsest_grid, strongest_periods
from identification.unknowns import EDGE, unknown_of
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve


def fitted(seed: int) -> tuple[dict[str, float], Fit]:
    plant = draw_plant(seed, ())
    taken = measure(plant, seed + 1000)
    record = Record.from_arrays(name="plant", time=taken["time"], current=taken["current"], position=taken["position"])
    valve = read_valve("calibrated")
    return plant.base, fit_base(Model(valve.name, valve.values), [experiment_of(record)])


@pytest.mark.parametrize("seed", range(6))
def test_ratios_of_a_blind_plant_are_recovered(seed: int) -> None:
    """Only ratios to S_1 P_1 enter current and position; the fit keeps S_1 and P_1, so all forces scale alike."""
    truth, fit = fitted(seed)
    found = {estimate.name: estimate for estimate in estimates(fit)}
    scale = truth["diaphragm_area"] / fit.model.values["diaphragm_area"]
    scale *= truth["supply_pressure"] / fit.model.values["supply_pressure"]
    for name in ("spring_rate", "coulomb_friction", "viscous_friction"):
        estimate = found[name]
        assert estimate.std is not None
        error = abs(estimate.value * scale - truth[name])
        assert error < max(0.02 * truth[name], 4.0 * estimate.std * scale), name
    for name in ("gap_offset", "gap_gain"):
        assert found[name].value == pytest.approx(truth[name], rel=2e-3)


def test_noise_is_read_off_the_record() -> None:
    generator = np.random.default_rng(3)
    time = np.arange(4000) * 0.02
    motion = 0.1 * np.sin(0.3 * time) + 0.02 * (time % 7.0 > 3.0)
    noisy = motion + 1e-4 * generator.standard_normal(len(time))
    assert noise_level(noisy) == pytest.approx(1e-4, rel=0.06)


@pytest.mark.parametrize(("noise", "expected"), [(1e-4, 1e-4), (2e-4, 2e-4), (3e-4, 3e-4), (5e-5, 1e-4)])
def test_noise_before_a_coarse_converter_makes_it_flicker(noise: float, expected: float) -> None:
    """Steps of 2 mm; what flickers less than a twentieth of a step would is not told from none."""
    generator = np.random.default_rng(6)
    time = np.arange(20000) * 0.02
    motion = 0.1 + 0.05 * np.sin(0.01 * time) + noise * generator.standard_normal(len(time))
    assert noise_level(2e-3 * np.round(motion / 2e-3)) == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("noise", [1e-4, 3e-4, 0.0])
def test_noise_before_a_coarse_converter_leaves_whole_steps(noise: float) -> None:
    generator = np.random.default_rng(7)
    time = np.arange(20000) * 0.02
    quiet = 0.1 + 0.05 * np.sin(0.01 * time)
    readings = 2e-3 * np.round((quiet + noise * generator.standard_normal(len(time))) / 2e-3)
    left = float(np.sqrt(np.mean((readings - 2e-3 * np.round(quiet / 2e-3)) ** 2)))
    assert flicker_level(readings) == pytest.approx(left, rel=0.1)
    readings[::50] = np.nan
    record = Record.from_arrays(name="coarse", time=time, current=np.full(len(time), 0.012), position=readings)
    assert experiment_of(record).floor == pytest.approx(max(left, 1e-4), rel=0.15)


def test_what_a_finer_display_shows_of_one_step_is_no_flicker() -> None:
    """Some levels lie between two marks of the display, and noise far below it shows one or the other."""
    generator = np.random.default_rng(8)
    time = np.arange(8000) * 0.02
    coarse = 3.006e-3 * np.round((0.1 + 0.08 * np.sin(0.2 * time)) / 3.006e-3)
    shown = 5e-5 * np.round((coarse + 2e-6 * generator.standard_normal(len(time))) / 5e-5)
    assert reading_grid(shown)[0] == pytest.approx(3.006e-3, rel=1e-3)
    assert np.mean(shown[1:-1] != shown[:-2]) > 0.05
    assert flicker_level(shown) < 5e-5
    assert noise_level(shown) == pytest.approx(0.05 * 3.006e-3, rel=1e-3)


def test_grid_of_coarse_readings() -> None:
    generator = np.random.default_rng(4)
    fine = generator.uniform(0.02, 0.2, 3000)
    step, offset = reading_grid(2e-3 * np.round((fine - 7e-4) / 2e-3) + 7e-4)
    assert step == pytest.approx(2e-3)
    assert offset == pytest.approx(7e-4, abs=1e-9)
    assert reading_grid(fine) == (0.0, 0.0) or reading_grid(fine)[0] < 5e-4


def test_grid_is_found_below_noise_on_top() -> None:
    generator = np.random.default_rng(5)
    time = np.arange(6000) * 0.02
    coarse = 3e-3 * np.round((0.12 + 0.1 * np.sin(0.2 * time)) / 3e-3)
    record = Record.from_arrays(
        name="grid",
        time=time,
        current=0.012 + 0.004 * np.sin(0.2 * time),
        position=coarse + 1e-4 * generator.standard_normal(len(time)),
    )
    assert coarsest_grid(experiment_of(record))[0] == pytest.approx(3e-3, rel=1e-3)


def test_a_few_levels_are_no_grid_where_a_smooth_fit_leaves_less_than_it_would_round_off() -> None:
    """Stairs with long holds: their levels lie on a grid of 4 mm by chance, the way between them does not."""
    generator = np.random.default_rng(5)
    time = np.arange(6000) * 0.02
    levels = 0.1 + 4e-3 * generator.integers(-12, 12, 12)
    way = np.interp(time % 10.0, [0.0, 1.5], [0.0, 1.0])
    place = (time // 10.0).astype(int)
    position = np.append(levels, 0.1)[place] * (1.0 - way) + np.append(levels[1:], [0.1, 0.1])[place] * way
    record = Record.from_arrays(
        name="stairs",
        time=time,
        current=0.012 + 0.004 * np.sin(0.2 * time),
        position=position + 8e-5 * generator.standard_normal(len(time)),
    )
    experiment = experiment_of(record)
    assert coarsest_grid(experiment)[0] == pytest.approx(4e-3, rel=1e-2)
    assert coarsest_grid(experiment, 1.1e-3)[0] == pytest.approx(4e-3, rel=1e-2)
    assert coarsest_grid(experiment, 3e-4)[0] < 1e-4


@pytest.mark.parametrize(("rows", "interval"), [(7500, 0.02), (1500, 0.1), (600, 0.2), (600, 0.5), (600, 2.0)])
def test_strongest_period_is_found_at_any_pace(rows: int, interval: float) -> None:
    time = np.arange(rows) * interval
    generator = np.random.default_rng(6)
    residual = np.sin(2 * np.pi * time / 23.0) + 0.5 * generator.standard_normal(len(time))
    assert strongest_periods(time, residual)[0] == pytest.approx(23.0, rel=0.05)


def test_covariance_of_a_straight_line() -> None:
    generator = np.random.default_rng(7)
    design = np.column_stack([np.ones(1000), np.linspace(-1.0, 1.0, 1000)])
    deviations = []
    for _ in range(200):
        noise = generator.standard_normal(1000)
        deviations.append(np.linalg.lstsq(design, noise, rcond=None)[0])
    stated = np.sqrt(np.diag(covariance(design, generator.standard_normal(1000), np.arange(1000) // 25)))
    assert stated == pytest.approx(np.std(deviations, axis=0), rel=0.35)


def test_what_a_record_does_not_determine_has_no_deviation() -> None:
    time = np.arange(2000) * 0.5
    current = 0.012 + 0.006 * np.sin(2 * np.pi * time / 300.0)
    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values)
    from valvemodel.simulation import simulate

    run = simulate(model, time=time, current=current)
    generator = np.random.default_rng(8)
    position = run.position + 1e-4 * generator.standard_normal(len(time))
    record = Record.from_arrays(name="slow", time=time, current=current, position=position)
    found = {each.name: each for each in estimates(fit_base(model, [experiment_of(record)]))}
    assert found["stem_mass"].std is None
    assert found["spring_rate"].std is not None


def test_an_extension_recovers_its_parameter() -> None:
    plant = draw_plant(4, ("asymmetric_viscous_friction",))
    taken = measure(plant, 1004)
    record = Record.from_arrays(name="plant", time=taken["time"], current=taken["current"], position=taken["position"])
    valve = read_valve("calibrated")
    base = fit_base(Model(valve.name, valve.values), [experiment_of(record)])
    fit = extend(base, "asymmetric_viscous_friction")
    assert fit.found.error < 0.9 * base.found.error
    assert abs(fit.model.effects["asymmetric_viscous_friction"]["viscous_asymmetry"]) > 0.02


def test_a_number_just_beside_its_bound_is_the_bound() -> None:
    """A search that keeps inside its bounds stands beside one; a lag of a microsecond would be dear to follow."""
    unknown = unknown_of(effect_of_key("coil_lag").parameter("coil_time_constant"))
    low, high = unknown.bounds
    values = unknown.value(np.array([low, low + 0.5 * EDGE, low + 2.0 * EDGE, high - 0.5 * EDGE]))
    assert values[:2].tolist() == [unknown.low, unknown.low]
    assert values[2] == pytest.approx(unknown.low + 2.0 * EDGE * unknown.spread)
    assert values[3] == unknown.high


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.key)
def test_no_number_of_an_effect_leaves_its_bounds_by_rounding(effect: Effect) -> None:
    """A search that ends on a bound must give a valve: that of a recovery over 200 s broke off before."""
    for unknown in (unknown_of(each) for each in effect.parameters if each.is_fitted):
        low, high = (float(unknown.value(end)) for end in unknown.bounds)
        assert unknown.low <= low == pytest.approx(unknown.low, rel=1e-12, abs=0.0)
        assert unknown.high >= high == pytest.approx(unknown.high, rel=1e-12, abs=0.0)
