"""What every effect must keep, walked over the declarations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulation_runs import (
    EFFECT_KEYS,
    FINE_TOLERANCE,
    base_model,
    ramps_and_steps,
    run,
    with_effects,
)

from identification.problem import SEARCH_TOLERANCE
from valvemodel import chain, runs
from valvemodel.effects import effect_of_key
from valvemodel.parameters import MEMORY, STATE
from valvemodel.trajectory import TOLERANCE

BASE = base_model()
TIME, CURRENT = ramps_and_steps(seconds=16.0, seed=4)
PLAIN = run(BASE, TIME, CURRENT)

INTEGRATED = {
    "coil_lag", "gap_drift", "chamber_filling", "asymmetric_filling", "supply_droop", "stribeck",
    "position_dependent_friction", "presliding", "spring_hardening", "load_force", "friction_drift",
}  # fmt: skip
"""Effects without a closed form; all others are the same at any tolerance, to the last bit."""


@pytest.mark.parametrize("key", EFFECT_KEYS)
def test_an_effect_at_its_neutral_values_is_absent_to_the_last_bit(key):
    neutral = {parameter.name: parameter.neutral for parameter in effect_of_key(key).parameters}
    assert (run(BASE.with_effect(key, **neutral), TIME, CURRENT) == PLAIN).all()


@pytest.mark.parametrize("key", EFFECT_KEYS)
def test_an_effect_at_its_typical_values_changes_the_readings(key):
    readings = run(with_effects(BASE, key), TIME, CURRENT)
    assert np.isfinite(readings).all()
    assert np.abs(readings - PLAIN).max() > 1e-5


@pytest.mark.parametrize("key", EFFECT_KEYS)
def test_refinement_moves_little(key):
    model = with_effects(BASE, key)
    # Stribeck friction soon hangs by a hair.
    some = slice(0, 80) if key == "stribeck" else slice(None)
    default = run(model, TIME[some], CURRENT[some])
    for tolerance, bound in ((FINE_TOLERANCE, 1e-9), (SEARCH_TOLERANCE, 5e-5)):
        other = run(model, TIME[some], CURRENT[some], tolerance=tolerance)
        # What a line delays is held for whole ticks in a coarse run, which is rounding.
        held = 1e-14 if key == "transport_delay" else 0.0
        assert np.abs(default - other).max() <= (bound if key in INTEGRATED else held)


def test_pairs_of_effects_stay_finite_and_within_reason():
    generator = np.random.default_rng(8)
    for _ in range(60):
        keys = generator.choice(EFFECT_KEYS, 2, replace=False)
        readings = run(with_effects(BASE, *keys), TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
        assert np.isfinite(readings).all(), keys
        assert np.abs(readings).max() < 1.0, keys


def test_all_effects_together_stay_finite():
    readings = run(with_effects(BASE, *EFFECT_KEYS), TIME, CURRENT, tolerance=SEARCH_TOLERANCE)
    assert np.isfinite(readings).all()


EXACT_KEYS = [
    "static_friction", "asymmetric_friction", "asymmetric_viscous_friction", "pressure_dependent_friction",
    "area_variation", "end_stop", "magnetic_hysteresis", "magnetic_saturation", "air_leak", "choked_flow",
    "linkage_backlash", "linkage_nonlinearity", "quantisation", "sensor_drift", "sensor_lag",
]  # fmt: skip


@pytest.mark.parametrize("key", [None, *EXACT_KEYS])
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_splitting_periods_changes_nothing(key, damping):
    model = base_model(viscous_friction=damping)
    model = with_effects(model, key) if key else model
    halved = np.empty(2 * len(TIME) - 1)
    halved[::2], halved[1::2] = TIME, 0.5 * (TIME[1:] + TIME[:-1])
    split = run(model, halved, np.repeat(CURRENT, 2)[:-1])[::2]
    assert np.abs(split - run(model, TIME, CURRENT)).max() < 1e-12


@pytest.mark.parametrize("key", [None, *EXACT_KEYS, "transport_delay", "stribeck", "coil_lag"])
def test_a_shift_of_time_changes_nothing(key):
    if key == "sensor_drift":
        pytest.skip("drifts with time")
    model = with_effects(BASE, key) if key else BASE
    shifted = run(model, TIME + 7.0, CURRENT)
    assert np.abs(shifted - run(model, TIME, CURRENT)).max() < 1e-9


@pytest.mark.parametrize(
    "key", ["static_friction", "stribeck", "presliding", "spring_hardening", "linkage_backlash", "sensor_lag"]
)
def test_mirrored_pressures_give_mirrored_readings(key):
    model = with_effects(BASE, key)
    pressure = 8e4 * np.sin(2.0 * np.pi * TIME / 5.0) + 3e4 * np.sign(np.sin(2.0 * np.pi * TIME / 1.3))
    up = run(model, TIME, pressure, driven_by=chain.PRESSURE)
    down = run(model, TIME, -pressure, driven_by=chain.PRESSURE)
    assert np.abs(up + down).max() < 1e-12


def test_mirrored_asymmetries_give_mirrored_readings():
    pressure = 8e4 * np.sin(2.0 * np.pi * TIME / 5.0)
    up = BASE.with_effect("asymmetric_friction", friction_asymmetry=0.3)
    down = BASE.with_effect("asymmetric_friction", friction_asymmetry=-0.3)
    up = up.with_effect("asymmetric_viscous_friction", viscous_asymmetry=0.5)
    down = down.with_effect("asymmetric_viscous_friction", viscous_asymmetry=-0.5)
    rising = run(up, TIME, pressure, driven_by=chain.PRESSURE)
    falling = run(down, TIME, -pressure, driven_by=chain.PRESSURE)
    assert np.abs(rising + falling).max() < 1e-12


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    damping=st.floats(0.0, 2000.0),
    coulomb=st.floats(0.0, 3000.0),
    ratio=st.floats(1.0, 3.0),
    start=st.floats(-0.2, 0.2),
    pressure=st.floats(-1e5, 2e5),
    key=st.sampled_from([None, "stribeck", "asymmetric_friction", "position_dependent_friction"]),
)
def test_friction_never_feeds_energy(damping, coulomb, ratio, start, pressure, key):
    """Under a held pressure the energy of mass, spring and pressure never grows."""
    model = base_model(viscous_friction=damping, coulomb_friction=coulomb)
    model = with_effects(model, key) if key else model
    model = model.with_effect("static_friction", static_friction_ratio=ratio)
    rows, states, memories = model.rows(), np.zeros(1, STATE), np.zeros(1, MEMORY)
    runs.run_chain(
        model.rows(start_position=start), states, memories, np.zeros(1),
        np.full(1, pressure), runs.FREE, chain.PRESSURE, 1e-9, np.empty((1, 1)), runs.NONE, runs.NONE,
    )  # fmt: skip
    values = model.values

    def energy() -> float:
        position, velocity = states["position"][0], states["velocity"][0]
        kinetic = 0.5 * values["stem_mass"] * velocity**2
        spring = 0.5 * values["spring_rate"] * position**2
        return float(kinetic + spring - values["diaphragm_area"] * pressure * position)

    before = energy()
    for _ in range(60):
        chain.move_stem(rows[0], states[0], memories[0], pressure, 0.0, 0.0013, 1e-9)
        after = energy()
        assert after <= before + 1e-9 * (1.0 + abs(before))
        before = after


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    damping=st.sampled_from([1.59, 60.0, 612.9, 5000.0]),
    ratio=st.floats(1.0, 2.0),
    cuts=st.lists(st.floats(0.001, 0.019), min_size=1, max_size=4, unique=True),
)
def test_cutting_periods_anywhere_changes_nothing(seed, damping, ratio, cuts):
    model = base_model(viscous_friction=damping).with_effect("static_friction", static_friction_ratio=ratio)
    time, current = ramps_and_steps(seconds=3.0, seed=seed)
    pieces = np.concatenate([[0.0], np.sort(cuts)])
    finer = (time[:, None] + pieces).ravel()
    cut = run(model, finer, np.repeat(current, len(pieces)))[:: len(pieces)]
    # Rounding of sample times: a nanosecond's thousandth at a metre a second.
    assert np.abs(cut - run(model, time, current)).max() < 1e-11


@pytest.mark.parametrize("key", EFFECT_KEYS)
def test_the_future_does_not_act(key):
    """The first part of a record gives the first part of the run, to the last bit."""
    model = with_effects(BASE, key)
    assert (run(model, TIME[:300], CURRENT[:300]) == run(model, TIME, CURRENT)[:300]).all()


def test_an_impossible_delay_of_the_whole_record_never_moves():
    model = BASE.with_effect("transport_delay", transport_delay=3.0)
    time, current = ramps_and_steps(seconds=2.0)
    assert np.ptp(run(model, time, current)) == 0.0


def test_a_delay_shifts_the_readings_whatever_the_sampling():
    generator = np.random.default_rng(3)
    time = np.concatenate([[0.0], np.cumsum(generator.uniform(0.005, 0.05, 400))])
    current = 12e-3 + 6e-3 * np.sin(time)
    delay = 0.2345
    delayed = run(BASE.with_effect("transport_delay", transport_delay=delay), time, current)
    # The same breakpoints, written out.
    both = np.unique(np.concatenate([time, time + delay]))
    held = current[np.clip(np.searchsorted(time, both - delay + 1e-12, side="right") - 1, 0, None)]
    expected = run(BASE, both, held)[np.searchsorted(both, time)]
    assert np.abs(delayed - expected).max() < 1e-11


@pytest.mark.parametrize("period", [1.0, 60.0])
@pytest.mark.parametrize("key", [None, "load_force", "coil_lag", "chamber_filling", "friction_drift", "stribeck"])
def test_long_holds_equal_short_ones(period, key):
    model = with_effects(BASE, key) if key else BASE
    current = np.array([8e-3, 15e-3, 11e-3, 18e-3, 9e-3, 9e-3])
    time = period * np.arange(6)
    parts = int(period / 0.02)
    finer = (time[:, None] + 0.02 * np.arange(parts)).ravel()
    long = run(model, time, current)
    short = run(model, finer, np.repeat(current, parts))[::parts]
    assert np.abs(long - short).max() < 1e-9


@pytest.mark.parametrize("damping", [1.59, 612.9])
@pytest.mark.parametrize("tolerance", [TOLERANCE, SEARCH_TOLERANCE])
@pytest.mark.parametrize("compliance", [1e-17, 1e-15, 1e-13, 1e-11, 1e-10])
def test_stiff_bristles_are_nearly_dry_friction(damping, tolerance, compliance):
    """Whether they are followed, coarsely followed as too much work, or taken for rigid."""
    base = base_model(viscous_friction=damping)
    stiff = base.with_effect("presliding", presliding_compliance=compliance)
    some = slice(0, 40)
    found = run(stiff, TIME[some], CURRENT[some], tolerance=tolerance)
    assert np.abs(found - run(base, TIME[some], CURRENT[some])).max() < 2e-5


@pytest.mark.parametrize("time_constant", [2e-4, 2e-3, 2e-2])
def test_quick_coil_beside_a_sagging_supply_is_followed_within_the_tolerance(time_constant):
    """What a polynomial over many time constants of the coil takes for a turn of the pressure is none."""
    model = with_effects(BASE, "supply_droop").with_effect("coil_lag", coil_time_constant=time_constant)
    exact, coarse = (run(model, TIME, CURRENT, tolerance=tolerance) for tolerance in (TOLERANCE, SEARCH_TOLERANCE))
    assert np.abs(coarse - exact).max() < SEARCH_TOLERANCE
    assert np.abs(run(model, TIME, CURRENT, tolerance=FINE_TOLERANCE) - exact).max() < 1e-9
