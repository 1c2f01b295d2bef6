"""Each effect against a closed form, and all of them at a vanishing magnitude."""

import numpy as np
import pytest

from diagnosis.blindtest.chain.electromagnet import _bouc_wen, _coleman_hodgdon
from diagnosis.blindtest.chain.nozzle import choked_pressure
from diagnosis.blindtest.chain.sensor import digitised
from diagnosis.blindtest.formulations import EFFECTS
from diagnosis.blindtest.truth import Truth
from diagnosis.blindtest.valve import draw_base, integrate

LAWS = [(key, law) for key, effect in EFFECTS.items() for law in effect.formulations if law.magnitude]
COARSE = 1e-4
# Smallest part of the lowest magnitude that the coarse step still integrates.
VANISHING = {"chamber_filling": 1e-2, "asymmetric_filling": 1e-2, "presliding": 0.1}


def truth_of(key, law, base, magnitude):
    numbers = law.draw(np.random.default_rng(3), base)
    return Truth(key, EFFECTS[key].stage, law.name, {**numbers, law.magnitude: magnitude})


def built(key, name, **numbers):
    return Truth(key, EFFECTS[key].stage, name, numbers)


def names(pair):
    return f"{pair[0]}-{pair[1].name}"


def test_all_27_effects_of_the_design_are_there():
    assert len(EFFECTS) == 27
    assert {effect.stage for effect in EFFECTS.values()} == {"electromagnet", "nozzle", "stem", "sensor"}


@pytest.mark.parametrize("pair", LAWS, ids=names)
def test_vanishing_effect_leaves_the_base_valve(pair, base, ramps):
    key, law = pair
    plain = integrate(base, *ramps, step=COARSE)["position"]
    weak = truth_of(key, law, base, law.lowest * VANISHING.get(key, 1e-4))
    seen = digitised(integrate(base, *ramps, step=COARSE, effects=(weak,))["position"], 0 * plain, 0, (weak,))
    # A stop acts at the travel that the test ramps reach, so its depth alone does not remove it.
    if key != "end_stop":
        assert np.sqrt(np.mean((seen - plain) ** 2)) < 1e-4


@pytest.mark.parametrize("pair", LAWS, ids=names)
def test_notable_effect_shows(pair, base, ramps):
    key, law = pair
    plain = integrate(base, *ramps, step=COARSE)["position"]
    strong = truth_of(key, law, base, np.sqrt(law.lowest * law.highest))
    seen = digitised(integrate(base, *ramps, step=COARSE, effects=(strong,))["position"], 0 * plain, 0, (strong,))
    assert np.all(np.isfinite(seen))
    if key != "end_stop":
        assert np.abs(seen - plain).max() > 2e-4


@pytest.mark.parametrize("name", ["karnopp", "rate_and_state", "lugre"])
def test_slip_jump_is_the_excess_over_the_spring(name, base):
    numbers = {"static_excess": 0.4, "decay_speed": 1e-4, "bond_distance": 1e-5, "bond_time": 0.3}
    numbers |= {"bristle_stiffness": 1e8, "bristle_damping": 3e4}
    time = np.arange(2000) / 50.0
    current = 8e-3 + 2e-4 * time
    position = integrate(base, time, current, effects=(built("static_friction", name, **numbers),))["position"]
    jump = np.diff(position, n=1)
    first = np.argmax(jump > 1e-3)
    height = position[first + 4] - position[first]
    # The bristles' own creep breaks some of their bonds before the stem slips.
    part = 0.82 if name == "lugre" else 1.0
    assert height == pytest.approx(part * 0.4 * base["coulomb_friction"] / base["spring_rate"], rel=0.05)


def test_delay_shifts_the_record(base, ramps):
    late = built("transport_delay", "pure", delay=0.1)
    plain = integrate(base, *ramps, step=COARSE)["position"]
    shifted = integrate(base, *ramps, step=COARSE, effects=(late,))["position"]
    assert np.abs(shifted[5:] - plain[:-5]).max() < 1e-12


def test_backlash_adds_the_play_to_the_dead_band(base, ramps):
    loose = built("linkage_backlash", "play", play=4e-3, start=0.0)
    true = integrate(base, *ramps, step=COARSE, effects=(loose,))
    difference = true["position"] - true["travel"]
    assert difference.min() == pytest.approx(-2e-3)
    assert difference.max() == pytest.approx(2e-3)


def test_sensor_lag_follows_the_exponential(base):
    time = np.arange(200) / 50.0
    current = np.where(time < 1.0, 8e-3, 14e-3)
    slow = built("sensor_lag", "first_order", time_constant=0.2)
    position = integrate(base, time, current, effects=(slow,))["position"]
    left = (position[-1] - position[70:100]) / (position[-1] - position[69:99])
    assert left == pytest.approx(np.exp(-0.02 / 0.2), rel=1e-3)


def test_coil_lag_follows_the_exponential(base):
    time = np.arange(200) / 50.0
    current = np.where(np.arange(200) < 50, 8e-3, 14e-3)
    slow = built("coil_lag", "inductance", time_constant=0.2)
    pressure = integrate(base, time, current, effects=(slow,))["pressure"]
    gap = np.sqrt((base["supply_pressure"] / pressure - 1) / base["flow_ratio"])
    acting = ((base["gap_offset"] - gap) / base["gap_gain"]) ** 2
    expected = 14e-3 - 6e-3 * np.exp(-(time[51:] - time[50]) / 0.2)
    assert acting[51:] == pytest.approx(expected, abs=1e-6)


def test_rate_limit_vents_in_a_straight_line(base):
    time = np.arange(200) / 50.0
    current = np.where(np.arange(200) < 50, 14e-3, 6e-3)
    numbers = {"slow_direction": -1.0, "slow_time": 6.0, "quick_share": 0.001}
    limited = built("asymmetric_filling", "rate_limit", **numbers)
    pressure = integrate(base, time, current, effects=(limited,))["pressure"]
    assert np.diff(pressure[52:80]) / 0.02 == pytest.approx(-base["supply_pressure"] / 6.0, rel=1e-6)


def test_chamber_comes_to_rest_at_the_static_pressure(base):
    time = np.arange(400) / 50.0
    current = np.where(np.arange(400) < 50, 6e-3, 15e-3)
    static = integrate(base, time, current)["pressure"]
    for name in ("constant_volume", "growing_volume", "isothermal"):
        filling = built("chamber_filling", name, fill_time=0.2, volume_growth=1.0)
        pressure = integrate(base, time, current, effects=(filling,))["pressure"]
        assert pressure[-1] == pytest.approx(static[-1], rel=1e-6)
        assert 0.2 < (pressure[55] - static[0]) / (static[-1] - static[0]) < 0.8


def test_incompressible_leak_divides_the_pressure(base, ramps):
    leak = built("air_leak", "incompressible", leak_area_ratio=0.5)
    ratio = (
        integrate(base, *ramps, step=COARSE, effects=(leak,))["pressure"]
        / integrate(base, *ramps, step=COARSE)["pressure"]
    )
    assert ratio == pytest.approx(1 / 1.25, rel=1e-4)


def test_choked_flow_balances_by_hand(base):
    # With nozzle and orifice both choked, area ratio A: (P1 + Pa) = A (P + Pa).
    law = built("choked_flow", "saint_venant")
    pressure = float(choked_pressure(np.array(2.4 / np.sqrt(base["flow_ratio"])), base, law))
    absolute = (base["supply_pressure"] + 101325.0) / 2.4
    assert 101325.0 / absolute > 0.528  # the nozzle is not choked here, so more pressure is held
    assert pressure > absolute - 101325.0
    wide = {**base, "supply_pressure": 9e5}
    pressure = float(choked_pressure(np.array(2.4 / np.sqrt(base["flow_ratio"])), wide, law))
    assert pressure + 101325.0 == pytest.approx((9e5 + 101325.0) / 2.4, rel=1e-9)


def test_choked_valve_keeps_the_converter_range():
    law = built("choked_flow", "iso_6358", critical_ratio=0.4)
    plain, choked = (draw_base(np.random.default_rng(5), truth) for truth in (None, law))
    for current in (4e-3, 20e-3):
        held = np.full(3, current), np.arange(3) / 50.0
        expected = integrate(plain, held[1], held[0])["pressure"]
        assert integrate(choked, held[1], held[0], effects=(law,))["pressure"] == pytest.approx(expected)


def test_hysteresis_loops_are_as_wide_as_said():
    current = np.concatenate([np.linspace(4, 20, 2000), np.linspace(20, 4, 2000)]) * 1e-3
    memory = _bouc_wen(current, 1e-3, 1.5)
    assert memory[1000] == pytest.approx(1.0, abs=1e-3)
    assert memory[3000] == pytest.approx(-1.0, abs=1e-3)
    lag = _coleman_hodgdon(current, 1e-3, 1.0) - current
    assert lag[1000] == pytest.approx(-1e-3, rel=1e-2)
    assert lag[3000] == pytest.approx(1e-3, rel=1e-2)


@pytest.mark.parametrize("name", ["lugre", "dahl", "iwan"])
def test_presliding_stem_yields_before_it_slides(name, base):
    compliance = 2e-6
    numbers = {"compliance": compliance, "bristle_damping": 300.0, "exponent": 1.0}
    time = np.arange(200) / 50.0
    current = np.where(np.arange(200) < 50, 10e-3, 10.2e-3)
    out = integrate(base, time, current, effects=(built("presliding", name, **numbers),))
    push = base["diaphragm_area"] * (out["pressure"][-1] - out["pressure"][0])
    elastic = push / (base["spring_rate"] + 1 / compliance)
    assert out["position"][-1] - out["position"][0] == pytest.approx(elastic, rel=0.35)


def test_sliders_turn_elastically_where_friction_is_higher_the_other_way(base):
    sliders = built("presliding", "iwan", compliance=2e-6)
    uneven = built("asymmetric_friction", "balanced", direction=-1.0, excess=0.4)
    time = np.arange(300) / 50.0
    current = np.concatenate([np.linspace(14e-3, 10e-3, 200), np.full(50, 10e-3), np.full(50, 10.2e-3)])
    out = integrate(base, time, current, effects=(sliders, uneven))
    rising, falling = (out["position"][n] for n in (-1, 249))
    push = base["diaphragm_area"] * (out["pressure"][-1] - out["pressure"][249])
    assert rising - falling == pytest.approx(push / (base["spring_rate"] + 1 / 2e-6), rel=0.2)


def test_stop_holds_and_lets_go(base, ramps):
    free = integrate(base, *ramps, step=COARSE)["position"]
    numbers = {"side": 1.0, "reference_travel": free.max(), "depth": 0.02, "stop_stiffness": 5e6}
    for name, give in (("rigid", 1e-12), ("elastic", 1e-3)):
        held = integrate(base, *ramps, step=COARSE, effects=(built("end_stop", name, **numbers),))["position"]
        assert held.max() == pytest.approx(free.max() - 0.02, abs=give)
        assert held[-1] == pytest.approx(free[-1], abs=1e-6)


def test_encoder_leaves_the_noise_and_converter_does_not():
    sampled, noise = np.linspace(0, 0.01, 500), np.full(500, 3e-4)
    for name, levels in (("converter", 11), ("encoder", 11)):
        coarse = built("quantisation", name, reading_step=1e-3, phase=0.0)
        seen = digitised(sampled, noise, 0.0, (coarse,))
        assert len(np.unique(np.round(seen, 9))) == levels
        assert (abs(seen % 1e-3 - 3e-4) < 1e-9).all() == (name == "encoder")
