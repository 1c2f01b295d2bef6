"""Bristles that damp, bristles of an exponent and sliders, against an integration that shares no code with them."""

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identification.problem import SEARCH_TOLERANCE
from valvemodel.model import Model
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

PERIOD = 0.02
TIME = np.arange(0.0, 0.8, PERIOD)
WAVES = 3.0 * np.sin(2.0 * np.pi * TIME / 0.8) + np.sin(2.0 * np.pi * TIME / 0.3)
STEPS = 0.3 * np.repeat(np.random.default_rng(3).standard_normal(8), 5)
CURRENT = (10.0 + WAVES + STEPS) * 1e-3

LAWS = {
    "lugre": {"bristle_damping": 600.0},
    "curved": {"bristle_exponent": 1.4},
    "curved and viscous": {"bristle_exponent": 2.2, "bristle_damping": 300.0},
    "sliders": {"slider_share": 1.0},
    "all": {"bristle_exponent": 1.3, "bristle_damping": 300.0, "slider_share": 0.5},
}


def with_law(law: str, compliance: float = 1e-6) -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values).with_effect("presliding", presliding_compliance=compliance, **LAWS[law])


def integrated(model: Model, pressure: np.ndarray, start: float, sliders: int = 16) -> np.ndarray:
    """Return the positions of a stem under pressures that are held over the periods, from rest without a force. [m]"""
    base, law = model.values, model.effects["presliding"]
    compliance, exponent = law["presliding_compliance"], law["bristle_exponent"]
    damping, share = law["bristle_damping"], law["slider_share"]
    level = base["coulomb_friction"]
    room = (np.arange(sliders) + 0.5) * 2.0 / sliders * level * compliance

    def rates(_, x, held):
        speed, bristle, bends = x[1], x[2], x[3:]
        side = 1.0 if speed > 0.0 else -1.0
        bristle_rate = speed * max(1.0 - side * bristle / level, 0.0) ** exponent / compliance
        bends_rate = np.where(side * bends < room, speed, 0.0) if share > 0.0 else np.zeros(sliders)
        slid = np.clip(bends, -room, room).sum() / (sliders * compliance)
        friction = (1.0 - share) * (bristle + damping * compliance * bristle_rate) + share * slid
        net = base["diaphragm_area"] * held - base["spring_rate"] * x[0] - base["spring_preload"] - friction
        return np.r_[speed, (net - base["viscous_friction"] * speed) / base["stem_mass"], bristle_rate, bends_rate]

    finest = np.r_[1e-14, 1e-11, 1e-9, np.full(sliders, 1e-14)]
    x, positions = np.r_[start, np.zeros(sliders + 2)], []
    for held in pressure:
        positions.append(x[0])
        found = solve_ivp(rates, (0.0, PERIOD), x, "DOP853", args=(held,), rtol=1e-11, atol=finest)
        x = found.y[:, -1]
        x[3:] = np.clip(x[3:], -room, room)
    return np.array(positions)


@pytest.mark.parametrize("compliance", [4e-7, 4e-6])
@pytest.mark.parametrize("law", LAWS)
def test_law_agrees_with_an_independent_integration(law, compliance):
    model = with_law(law, compliance)
    found = simulate(model, time=TIME, current=CURRENT)
    expected = integrated(model, np.r_[found.pressure[1:], found.pressure[-1]], found.position[0])
    assert np.ptp(expected) > 0.01
    assert np.abs(found.position - expected).max() < 1e-9
    quick = simulate(model, time=TIME, current=CURRENT, tolerance=SEARCH_TOLERANCE)
    assert np.abs(quick.position - expected).max() < 5e-5


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("key", ["asymmetric_friction", "sensor_lag", "chamber_filling"])
def test_law_beside_another_effect_agrees_with_the_reference(law, key):
    few = slice(0, 25)
    model = with_law(law).with_effect(key)
    found = simulate(model, time=TIME[few], current=CURRENT[few]).position
    assert np.abs(found - simulate_slowly(model, time=TIME[few], current=CURRENT[few]).position).max() < 5e-9


@pytest.mark.parametrize("key", ["friction_drift", "pressure_dependent_friction", "stribeck"])
def test_curved_bristles_follow_a_friction_that_changes(key):
    few = slice(0, 25)
    model = with_law("curved and viscous").with_effect(key)
    found = simulate(model, time=TIME[few], current=CURRENT[few]).position
    assert np.abs(found - simulate_slowly(model, time=TIME[few], current=CURRENT[few]).position).max() < 1e-8


@pytest.mark.parametrize("law", ["sliders", "all"])
@pytest.mark.parametrize("key", ["friction_drift", "pressure_dependent_friction"])
def test_sliders_beside_a_friction_that_changes_agree_with_the_reference(law, key):
    few = slice(0, 25)
    model = with_law(law).with_effect(key)
    found = simulate(model, time=TIME[few], current=CURRENT[few]).position
    assert np.abs(found - simulate_slowly(model, time=TIME[few], current=CURRENT[few]).position).max() < 1e-8


@numba.njit
def stepped(pressure, start, steps, mass, viscous, spring, area, coulomb, seal, height, middle, width, compliance):
    """Return the positions of a stem on sliders that carry what friction holds at each instant, by fine steps. [m]"""
    count, step, position, speed = 16, PERIOD / steps, start, 0.0
    bends, positions = np.zeros(count), np.empty(pressure.size)
    for period in range(pressure.size):
        positions[period] = position
        for _ in range(steps):
            bump = height * np.exp(-(((position - middle) / width) ** 2))
            limit = coulomb * (1.0 + bump) + seal * pressure[period]
            friction = 0.0
            for index in range(count):
                room = (index + 0.5) * 2.0 / count * limit * compliance
                bends[index] = min(max(bends[index] + step * speed, -room), room)
                friction += bends[index] / (count * compliance)
            net = area * pressure[period] - spring * position - friction
            before = speed
            speed = (speed + step * net / mass) / (1.0 + step * viscous / mass)
            position += 0.5 * step * (before + speed)
    return positions


@pytest.mark.parametrize(
    ("key", "numbers"),
    [
        ("pressure_dependent_friction", {"friction_area": 0.02}),
        ("position_dependent_friction", {"tight_spot_excess": 1.0, "tight_spot_width": 0.01}),
    ],
)
def test_sliders_slide_where_a_friction_falls_that_held_them(key, numbers):
    """As the pressure falls, or as the stem leaves a tight spot, the limit falls on sliders bent the other way."""
    current = (11.0 + 4.0 * np.sign(np.sin(2.0 * np.pi * TIME / 0.3)) + 0.5 * np.sin(2.0 * np.pi * TIME / 0.1)) * 1e-3
    model = with_law("sliders", 4e-6).with_effect(key, **numbers)
    found = simulate(model, time=TIME, current=current)
    v, e = model.values, model.effects[key]
    law = (v["coulomb_friction"], e.get("friction_area", 0.0), e.get("tight_spot_excess", 0.0))
    spot = (e.get("tight_spot_position", 0.0), e.get("tight_spot_width", 1.0), 4e-6)
    valve = (v["stem_mass"], v["viscous_friction"], v["spring_rate"], v["diaphragm_area"])
    held = np.r_[found.pressure[1:], found.pressure[-1]]
    coarse, fine = (stepped(held, found.position[0], steps, *valve, *law, *spot) for steps in (20000, 40000))
    assert np.ptp(fine) > 0.01
    # The steps' error falls with their length.
    assert np.abs(found.position - (2.0 * fine - coarse)).max() < 5e-8
    quick = simulate(model, time=TIME, current=current, tolerance=SEARCH_TOLERANCE)
    assert np.abs(quick.position - found.position).max() < 5e-5


def test_sliders_close_their_loops_and_bristles_creep_on():
    """A small cycle of an overdamped stem returns to where it began (Masing), but ratchets on bristles that forget."""
    valve = read_valve("calibrated")
    heavy = Model(valve.name, {**valve.values, "viscous_friction": 5000.0})
    cycles = np.tile(np.r_[np.full(20, 1.0), np.full(20, 0.0)], 3)
    current = (12.0 + np.r_[np.full(20, -1.0), np.zeros(20), 0.2 * cycles]) * 1e-3
    time = PERIOD * np.arange(len(current))

    def gained(share: float) -> float:
        model = heavy.with_effect("presliding", presliding_compliance=4e-6, slider_share=share)
        ends = simulate(model, time=time, current=current).position[79::40]
        return float(ends[1] - ends[0])

    assert abs(gained(1.0)) < 1e-9
    assert gained(0.0) > 1e-4
