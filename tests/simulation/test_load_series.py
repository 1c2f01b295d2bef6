"""A load of many waves is the same force in every form of the chain."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run

from identification.problem import SEARCH_TOLERANCE
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.smooth.chain import SmoothChain, parts_for, run_smooth
from valvemodel.stages.drifts import longest_period, may_hold_drifts
from valvemodel.stages.load import MOST_WAVES, load, steepest_slope, usual_slope

TIME, CURRENT = ramps_and_steps(seconds=12.0, seed=3)
SIZES = np.random.default_rng(1).normal(0.0, 30.0, (2, MOST_WAVES))
PERIOD = 60.0


def series(waves: int, period: float = PERIOD):
    values = {"load_period": period, "load_waves": float(waves), "load_sine": SIZES[0, 0], "load_cosine": SIZES[1, 0]}
    for number in range(2, MOST_WAVES + 1):
        values |= {f"load_sine_{number}": SIZES[0, number - 1], f"load_cosine_{number}": SIZES[1, number - 1]}
    return base_model().with_effect("load_force", **values)


def force_at(time: np.ndarray, waves: int) -> np.ndarray:
    angles = 2.0 * np.pi / PERIOD * np.outer(time, np.arange(1, waves + 1))
    return np.sin(angles) @ SIZES[0, :waves] + np.cos(angles) @ SIZES[1, :waves]


@pytest.mark.parametrize("waves", [1, 2, 7, MOST_WAVES])
def test_as_many_waves_act_as_are_said(waves):
    row = series(waves).rows()[0]
    expected = force_at(TIME[::20], waves)
    assert [load(row, time) for time in TIME[::20]] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("waves", [1, 5, MOST_WAVES])
def test_the_slope_of_the_load_stays_within_its_bound(waves):
    row = series(waves).rows()[0]
    time = np.linspace(0.0, PERIOD, 20_001)
    slope = np.abs(np.gradient(force_at(time, waves), time))
    assert slope.max() <= steepest_slope(row) * (1.0 + 1e-6) < 4.0 * slope.max()
    assert usual_slope(row) == pytest.approx(np.sqrt(2.0) * np.sqrt((slope**2).mean()), rel=1e-3)


def test_the_exact_run_agrees_with_two_that_share_no_code_with_it():
    model = series(MOST_WAVES)
    exact = run(model, TIME, CURRENT)
    independent = IndependentChain.of(model).run(TIME, CURRENT)
    assert np.abs(exact - independent).max() < 1e-6
    slowly = simulate_slowly(model, time=TIME, current=CURRENT)
    assert np.abs(simulate(model, time=TIME, current=CURRENT).position - slowly.position).max() < 1e-6
    assert np.abs(exact - run(series(1), TIME, CURRENT)).max() > 1e-3


def test_a_coarse_run_holds_the_load_for_a_period():
    model = series(MOST_WAVES, 3.0 * PERIOD)
    assert may_hold_drifts(model.rows()[0], longest_period(TIME), SEARCH_TOLERANCE)
    coarse = run(model, TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
    assert np.sqrt(np.mean((coarse - run(model, TIME, CURRENT)) ** 2)) < SEARCH_TOLERANCE


def test_the_smooth_chain_converges_to_the_exact_run():
    model = series(MOST_WAVES)
    exact = simulate(model, time=TIME, current=CURRENT, start_position=0.02).position
    chain = SmoothChain(model, parts=parts_for(model, float(np.diff(TIME).max())))
    largest = [
        np.abs(run_smooth(chain, time=TIME, current=CURRENT, start_position=0.02, width=width) - exact).max()
        for width in (10.0, 0.1)
    ]
    # What a part takes as held is left over.
    assert largest[1] < min(0.2 * largest[0], 2e-5)


def test_the_work_of_the_load_goes_into_friction_and_the_spring():
    model = series(MOST_WAVES)
    found = simulate(model, time=TIME, current=CURRENT)
    dense = found.at(np.linspace(TIME[0], TIME[-1], 400_001))
    values = model.values
    power = values["viscous_friction"] * dense.velocity**2 + values["coulomb_friction"] * np.abs(dense.velocity)
    assert found.energies.dissipated[-1] == pytest.approx(np.trapezoid(power, dense.time), rel=1e-5)
