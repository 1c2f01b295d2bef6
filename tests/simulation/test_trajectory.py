"""Events, energies and what stands between the samples, against closed forms and against a finer run."""

import math

import numpy as np
import pytest
from simulation_runs import EFFECT_KEYS, base_model, ramps_and_steps, with_effects

from valvemodel.errors import InputError
from valvemodel.simulation import AT_REST, simulate
from valvemodel.stages import EFFECTS

TIME, CURRENT = ramps_and_steps(seconds=6.0)
MOVING = {"coil_lag", "chamber_filling", "asymmetric_filling", "supply_droop"}
INTEGRATED = {*MOVING, "load_force", "stribeck", "presliding", "position_dependent_friction", "spring_hardening"}
INTEGRATED |= {"gap_drift", "friction_drift"}


def test_a_ramp_breaks_away_at_the_breakaway_force_over_its_rate():
    """On the affine valve a ramp of current is a ramp of force; held, it breaks away at the first step beyond F_s."""
    rate, ratio = 1e-3, 1.4
    per_current = 170e3 / 16e-3
    model = base_model(pressure_at_zero_current=0.0, pressure_per_current=per_current).with_effect(
        "static_friction", static_friction_ratio=ratio
    )
    period = 1e-4
    time = period * np.arange(40_000)
    run = simulate(model, time=time, current=8e-3 + rate * time)
    values = model.values
    expected = ratio * values["coulomb_friction"] / (values["diaphragm_area"] * per_current * rate)
    assert run.events.kind[0] == "breakaway"
    assert expected <= run.events.time[0] <= expected + 1.01 * period


@pytest.mark.parametrize("key", [None, *(key for key in EFFECT_KEYS if key not in INTEGRATED)])
def test_between_the_samples_is_what_a_finer_run_gives(key):
    model = with_effects(base_model(), key) if key else base_model()
    run = simulate(model, time=TIME, current=CURRENT)
    parts = 3
    fine = np.linspace(TIME[0], TIME[-1], parts * (len(TIME) - 1) + 1)
    fine[::parts] = TIME
    finer = simulate(model, time=fine, current=np.repeat(CURRENT, parts)[: len(fine)])
    between = run.at(fine)
    assert np.abs(between.position - finer.position).max() < 1e-12
    assert np.abs(between.velocity - finer.velocity).max() < 1e-9
    assert np.abs(run.at(TIME).position - run.position).max() == 0.0


def test_looking_between_changes_no_sample():
    model = with_effects(base_model(), "transport_delay", "static_friction", "sensor_lag")
    run = simulate(model, time=TIME, current=CURRENT)
    instants = np.sort(np.random.default_rng(0).uniform(TIME[0], TIME[-1], 1000))
    samples, _, _ = run.setting.trace(TIME, CURRENT, instants, 0)
    assert (samples["reading"] == run.position).all()


def test_instants_outside_a_run_are_refused():
    run = simulate(base_model(), time=TIME, current=CURRENT)
    for instants in ([-0.1], [TIME[-1] + 0.1], [1.0, 0.5]):
        with pytest.raises(InputError):
            run.at(instants)


def test_the_work_of_friction_on_a_ringing_stem_is_its_force_times_its_way():
    """Coulomb oscillator without viscous friction: each reversal is an event, the way is known from them."""
    coulomb = 300.0
    model = base_model(viscous_friction=0.0, coulomb_friction=coulomb)
    time = np.arange(0.0, 2.0, 0.02)
    current = np.where(time < 0.1, 10e-3, 16e-3)
    run = simulate(model, time=time, current=current)
    events = run.events
    assert events.kind[0] == "breakaway"
    assert set(events.kind[1:-1]) == {"reversal"}
    assert events.kind[-1] == "stop"
    half_swing = math.pi * math.sqrt(model.values["stem_mass"] / model.values["spring_rate"])
    assert np.abs(np.diff(events.time) - half_swing).max() < 1e-12
    swings = np.abs(np.diff(events.position))
    assert np.abs(np.diff(swings) + 4.0 * coulomb / model.values["spring_rate"]).max() < 1e-12
    assert run.energies.dissipated[-1] == pytest.approx(coulomb * swings.sum(), rel=1e-8)
    assert run.energies.kinetic[-1] == 0.0


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.key)
def test_friction_only_takes(effect):
    run = simulate(with_effects(base_model(), effect.key), time=TIME, current=CURRENT)
    # A bristle gives back what it stores: F_c times its reach.
    given_back = 0.05 if effect.key == "presliding" else 1e-2 if effect.key in INTEGRATED else 1e-9
    assert np.diff(run.energies.dissipated).min() > -given_back
    assert run.energies.dissipated[-1] > 100.0


def test_a_run_is_put_anew_at_its_intervals_and_only_then():
    time, current = TIME, CURRENT
    valve = with_effects(base_model(), "static_friction", "linkage_backlash")
    measured = simulate(valve, time=time, current=current).position + 1e-3 * np.sin(40.0 * time)
    model = base_model()
    run = simulate(model, time=time, current=current, measured=measured, reanchor=2.0)
    at_anchor = np.isclose(time % 2.0, 0.0) | np.isclose(time % 2.0, 2.0)
    assert np.abs(run.position - measured)[at_anchor].max() < 1e-15
    only = np.where(at_anchor, measured, 123.0)
    same = simulate(model, time=time, current=current, measured=only, reanchor=2.0)
    assert (same.position == run.position).all()
    free = simulate(model, time=time, current=current, measured=measured)
    assert (free.position == simulate(model, time=time, current=current).position).all()


def test_a_right_model_that_is_put_anew_stays_right():
    model = with_effects(base_model(), "static_friction", "coil_lag")
    truth = simulate(model, time=TIME, current=CURRENT)
    for reanchor in (0.5, AT_REST):
        run = simulate(model, time=TIME, current=CURRENT, measured=truth.position, reanchor=reanchor)
        assert np.abs(run.position - truth.position).max() < 1e-9


def test_put_anew_at_rest_only_where_it_comes_to_rest():
    measured = simulate(base_model(), time=TIME, current=CURRENT).position + 2e-3
    run = simulate(
        base_model(), time=TIME, current=CURRENT, measured=measured, reanchor=AT_REST, start_position=measured[0]
    )
    stops = run.events.time[run.events.kind == "stop"]
    first = np.searchsorted(TIME, stops)
    assert np.abs(run.position[first] - measured[first]).max() < 1e-15
    assert len(first) > 3


@pytest.mark.parametrize("reanchor", [0.0, -1.0, math.nan, "often"])
def test_an_impossible_horizon_is_refused(reanchor):
    with pytest.raises(InputError):
        simulate(base_model(), time=TIME, current=CURRENT, measured=np.zeros(len(TIME)), reanchor=reanchor)


def test_nothing_to_be_put_on_is_refused():
    with pytest.raises(InputError, match="needs measured positions"):
        simulate(base_model(), time=TIME, current=CURRENT, reanchor=2.0)
