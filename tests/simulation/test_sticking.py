"""The speed below which a slip sticks: in closed form, integrated, and what it does to a slow ramp."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, with_effects

from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate


def sticking(speed: float, *others: str, ratio: float = 1.2, damping: float = 612.9):
    model = base_model(viscous_friction=damping)
    model = model.with_effect("static_friction", static_friction_ratio=ratio, stick_speed=speed)
    return with_effects(model, *others)


@pytest.mark.parametrize("damping", [1.59, 60.0, 612.9])
@pytest.mark.parametrize("speed", [1e-4, 2e-3, 2e-2])
def test_closed_form_is_the_same_in_plain_python(speed, damping):
    time, current = ramps_and_steps(seconds=15.0, seed=1)
    model = sticking(speed, damping=damping)
    found = simulate(model, time=time, current=current).position
    assert np.abs(found - simulate_slowly(model, time=time, current=current).position).max() < 2e-14
    assert (found != simulate(sticking(1e-6, damping=damping), time=time, current=current).position).any()


@pytest.mark.parametrize("other", ["chamber_filling", "spring_hardening", "load_force", "friction_drift"])
@pytest.mark.parametrize("speed", [1e-3, 1e-2])
def test_integrated_run_is_within_its_tolerance(speed, other):
    model = sticking(speed, other)
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    assert np.abs(run(model, time, current) - expected).max() < 1e-9


@pytest.mark.parametrize("other", ["chamber_filling", "supply_droop", "stribeck"])
def test_a_slip_that_has_only_begun_does_not_stick(other):
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    found = simulate(sticking(2e-2, other), time=time, current=current)
    assert 0 < (found.events.kind == "breakaway").sum() < 60


def test_slow_ramp_goes_in_stairs_of_the_jump():
    """A ramp slower than the stick speed: rests, and jumps of 2 (F_s - F_c) / k at most, (F_s - F_c) / k at least."""
    time = 0.02 * np.arange(3000)
    current = np.linspace(8e-3, 14e-3, len(time))
    smooth, stairs = (simulate(sticking(speed), time=time, current=current) for speed in (1e-6, 1e-2))
    assert (np.diff(smooth.position) > 0.0).mean() > 0.4
    assert (np.diff(stairs.position) == 0.0).mean() > 0.9
    rests = stairs.position[1:][(np.diff(stairs.position) == 0.0)]
    jumps = np.diff(np.unique(rests))[1:]
    values = base_model().values
    height = 0.2 * values["coulomb_friction"] / values["spring_rate"]
    assert len(jumps) >= 3
    assert ((jumps > 0.9 * height) & (jumps < 1.5 * height)).all()
