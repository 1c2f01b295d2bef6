"""The describing function of stiction against python-control's, numerical harmonics and the exact simulator."""

import control as ct
import numpy as np
import pytest

from valvemodel.linear import stiction_nonlinearity
from valvemodel.model import Model
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

AMPLITUDES = np.array([0.4, 0.9, 1.01, 1.4, 3.0, 20.0])


def test_without_a_jump_it_is_python_control_s_backlash():
    own = ct.describing_function(stiction_nonlinearity(0.7, 0.7), AMPLITUDES)
    assert np.allclose(own, ct.describing_function(ct.friction_backlash_nonlinearity(1.4), AMPLITUDES), atol=1e-12)


@pytest.mark.parametrize("kinetic", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("amplitude", [1.01, 1.4, 3.0, 20.0])
def test_closed_form_is_the_first_harmonic_of_the_element(kinetic, amplitude):
    closed = stiction_nonlinearity(1.0, kinetic).describing_function(amplitude)
    (summed,) = ct.describing_function(
        stiction_nonlinearity(1.0, kinetic), [amplitude], num_points=4000, try_method=False
    )
    assert abs(closed - summed) < 1e-3


def test_input_that_is_too_small_moves_nothing():
    assert stiction_nonlinearity(1.0, 0.5).describing_function(0.7) == 0.0
    with pytest.raises(ValueError, match="below kinetic"):
        stiction_nonlinearity(0.5, 1.0)


def test_slow_sine_through_the_exact_valve_has_that_harmonic():
    valve = read_valve("linear")
    model = Model(valve.name, valve.values, {"static_friction": {"static_friction_ratio": 1.3}})
    period, turns = 400.0, 3
    time = np.arange(0.0, turns * period + 0.01, 0.01)
    angle = 2.0 * np.pi * time / period
    swing = 4e-3
    run = simulate(model, time=time, current=12e-3 + swing * np.sin(angle))
    last = slice(-round(period / 0.01) - 1, -1)
    harmonic = 2j * np.mean(run.position[last] * np.exp(-1j * angle[last]))
    amplitude, breakaway, sliding = swing * 0.0645 / 52500.0 * 10.625e6, 1.3 * 1423.0 / 52500.0, 1423.0 / 52500.0
    expected = amplitude * stiction_nonlinearity(breakaway, sliding).describing_function(amplitude)
    assert abs(harmonic - expected) < 2e-3 * abs(expected)
