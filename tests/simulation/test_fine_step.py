"""Every effect against an integrator with a fixed fine step that shares no code with the simulator.

Bounds are on the largest difference of the reading over ramps and steps. Where the reference holds a drifting force or
a filling pressure over its own step, the bound is the reference's error.
"""

import math

import numpy as np
import pytest
from simulation_runs import base_model, ramps_and_steps, run

from diagnosis.blindtest.chain.clock import clock_of
from diagnosis.blindtest.chain.stem import stem_of, stem_travel
from diagnosis.blindtest.truth import Truth
from diagnosis.blindtest.valve import integrate

BASE = base_model()
SECONDS = 8.0
COULOMB, DAMPING = 1423.0, 612.9


def reference(model, time, current, truths=(), *, step=2e-6):
    return integrate(dict(model.values), time, current, step=step, effects=tuple(truths))["position"]


@pytest.mark.parametrize("values", [{}, {"viscous_friction": 1.59}, {"travel_min": 0.06, "travel_max": 0.2}])
def test_a_minute_of_ramps_and_steps(values):
    time, current = ramps_and_steps(seconds=60.0)
    model = base_model(**values)
    difference = np.abs(run(model, time, current) - reference(model, time, current))
    # An undamped ring of centimetres at 31 Hz is the reference's own error.
    assert difference.max() < (2e-5 if "viscous_friction" in values else 1e-8)


def truth(effect, stage, formulation, **numbers):
    return Truth(effect, stage, formulation, numbers)


CASES = {
    "load_force": (
        truth("load_force", "stem", "sine", load_period=7.0, phase=0.4, amplitude=300.0),
        {"load_sine": -300.0 * math.cos(0.4), "load_cosine": -300.0 * math.sin(0.4), "load_period": 7.0},
        3e-7,
    ),
    "asymmetric_friction": (
        truth("asymmetric_friction", "stem", "balanced", direction=1.0, excess=0.3),
        {"friction_asymmetry": 0.3},
        1e-8,
    ),
    "position_dependent_friction": (
        truth("position_dependent_friction", "stem", "gaussian", height=0.8, centre=0.12, width=0.01),
        {"tight_spot_excess": 0.8, "tight_spot_position": 0.12, "tight_spot_width": 0.01 * math.sqrt(2.0)},
        1e-7,
    ),
    "pressure_dependent_friction": (
        truth("pressure_dependent_friction", "stem", "linear", growth=0.5, pressure_scale=3e5),
        {"friction_area": COULOMB * 0.5 / 3e5},
        1e-8,
    ),
    "spring_hardening": (
        truth("spring_hardening", "stem", "cubic", stiffening=0.2),
        {"spring_hardening": 0.2 / 0.04},
        1e-7,
    ),
    "area_variation": (
        truth("area_variation", "stem", "linear", direction=-1.0, change=0.1),
        {"area_slope": -0.5},
        1e-8,
    ),
    "friction_drift": (
        truth("friction_drift", "stem", "exponential", growth=0.3, time_constant=30.0),
        {"friction_drift_rate": 0.3 / 30.0, "friction_drift_time": 30.0},
        4e-6,
    ),
    "stribeck": (
        truth("stribeck", "stem", "exponential", static_excess=0.3, stribeck_speed=0.02),
        {"stribeck_ratio": 1.3, "stribeck_velocity": 0.02},
        2e-6,
    ),
    "presliding": (
        truth("presliding", "stem", "dahl", compliance=1e-6, exponent=1.0),
        {"presliding_compliance": 1e-6},
        1e-5,
    ),
    "linkage_backlash": (
        truth("linkage_backlash", "sensor", "play", play=6e-3, start=0.0),
        {"backlash_half_width": 3e-3},
        1e-8,
    ),
    "sensor_lag": (
        truth("sensor_lag", "sensor", "first_order", time_constant=0.08),
        {"sensor_time_constant": 0.08},
        1e-6,
    ),
    "sensor_drift": (
        truth("sensor_drift", "sensor", "exponential", direction=-1.0, zero_change=5e-3, time_constant=30.0),
        {"sensor_drift_rate": -5e-3 / 30.0, "sensor_drift_time": 30.0},
        1e-8,
    ),
    "gap_drift": (
        truth("gap_drift", "electromagnet", "exponential", direction=1.0, gap_change=2e-6, time_constant=30.0),
        {"gap_drift_rate": 2e-6 / 30.0, "gap_drift_time": 30.0},
        6e-6,
    ),
    "coil_lag": (
        truth("coil_lag", "electromagnet", "inductance", time_constant=0.2),
        {"coil_time_constant": 0.2},
        1e-5,
    ),
    "magnetic_hysteresis": (
        truth("magnetic_hysteresis", "electromagnet", "coleman_hodgdon", loop_half_width=4e-4, loop_reach=1.6e-3),
        {"hysteresis_half_width": 4e-4, "hysteresis_roundness": 1.0},
        1e-8,
    ),
    "choked_flow": (
        truth("choked_flow", "nozzle", "iso_6358", critical_ratio=0.45),
        {"compressible_share": 1.0, "critical_pressure_ratio": 0.45},
        1e-8,
    ),
    "transport_delay": (
        truth("transport_delay", "nozzle", "pure", delay=0.137),
        {"transport_delay": 0.137},
        1e-8,
    ),
    "chamber_filling": (
        truth("chamber_filling", "nozzle", "constant_volume", fill_time=0.4),
        {"chamber_filling_time": 0.4},
        5e-6,
    ),
    "asymmetric_filling": (
        truth(
            "asymmetric_filling", "nozzle", "two_time_constants",
            slow_direction=-1.0, quick_share=0.2, slow_time=0.3,
        ),
        {"fill_time": 0.06, "vent_time": 0.3, "filling_slowness": 0.0},
        1e-5,
    ),
}  # fmt: skip


@pytest.mark.parametrize("key", CASES)
def test_effect_against_the_fine_step(key):
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    made, values, bound = CASES[key]
    found = run(BASE.with_effect(key, **values), time, current)
    expected = reference(BASE, time, current, [made], step=1e-6)
    assert np.abs(found - reference(BASE, time, current)).max() > 1e-4
    assert np.abs(found - expected).max() < bound


@pytest.mark.parametrize("key", ["asymmetric_friction", "pressure_dependent_friction"])
def test_friction_drifts_wherever_it_stems_from(key):
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    made, models = [], [BASE]
    for each in ("friction_drift", key):
        made.append(CASES[each][0])
        models.append(models[-1].with_effect(each, **CASES[each][1]))
    expected = reference(BASE, time, current, made, step=1e-6)
    alone = sum(run(BASE.with_effect(each, **CASES[each][1]), time, current) for each in ("friction_drift", key))
    assert np.abs(alone - run(BASE, time, current) - expected).max() > 1e-4
    assert np.abs(run(models[-1], time, current) - expected).max() < 5e-6


def test_second_order_transmitter_is_two_equal_lags():
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    made = truth("sensor_lag", "sensor", "second_order", time_constant=0.16)
    model = BASE.with_effect("sensor_lag", sensor_time_constant=0.08, sensor_second_time_constant=0.08)
    assert np.abs(run(model, time, current) - reference(BASE, time, current, [made], step=1e-6)).max() < 1e-6


@pytest.mark.parametrize("other", ["", "chamber_filling"])
def test_a_line_that_smears(other):
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    made = [truth("transport_delay", "nozzle", "dispersive_line", delay=0.2, dispersion=0.1)]
    model = BASE.with_effect("transport_delay", transport_delay=0.2, line_dispersion=0.1)
    if other:
        made.append(CASES[other][0])
        model = model.with_effect(other, **CASES[other][1])
    assert np.abs(run(model, time, current) - reference(BASE, time, current, made, step=1e-6)).max() < 2e-5


def test_viscous_friction_that_differs_up_and_down():
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    made = truth("asymmetric_viscous_friction", "stem", "one_sided", direction=1.0, excess=8.0)
    model = base_model(viscous_friction=DAMPING * 5.0).with_effect(
        "asymmetric_viscous_friction", viscous_asymmetry=4.0 / 5.0
    )
    assert np.abs(run(model, time, current) - reference(BASE, time, current, [made])).max() < 1e-7


def test_end_stop_is_a_travel_limit():
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    stopped = run(BASE.with_effect("end_stop", upper_stop=0.18, lower_stop=0.07), time, current)
    limited = base_model(travel_max=0.18, travel_min=0.07)
    assert (stopped == run(limited, time, current)).all()
    assert np.abs(stopped - reference(limited, time, current)).max() < 1e-8


def test_pairs_of_effects_against_the_fine_step():
    time, current = ramps_and_steps(seconds=SECONDS, seed=2)
    keys = list(CASES)
    generator = np.random.default_rng(5)
    for _ in range(8):
        first, second = (keys[i] for i in generator.choice(len(keys), 2, replace=False))
        if {"transport_delay", "asymmetric_filling"} == {first, second}:
            continue
        model = BASE.with_effect(first, **CASES[first][1]).with_effect(second, **CASES[second][1])
        expected = reference(BASE, time, current, [CASES[first][0], CASES[second][0]], step=2e-6)
        difference = np.abs(run(model, time, current) - expected).max()
        assert difference < 2e-5, f"{first} with {second}: {difference}"


def droop_reference(time, current, *, gain, recovery):
    """Pressure under a sagging supply by small explicit steps, then the independent stem."""
    values = BASE.values
    clock = clock_of(time, 4e-6)
    gap = values["gap_offset"] - values["gap_gain"] * np.sqrt(current)
    shares = 1.0 / (1.0 + values["flow_ratio"] * gap**2)
    supply = values["supply_pressure"]
    sag, share = 0.0, shares[0]
    pressure = np.empty((clock.periods, clock.substeps))
    for period in range(clock.periods):
        increments = np.linspace(share, shares[period], 4001)
        for following in increments[1:]:
            before = (supply - sag) * share
            rise = (supply - sag) * following - before
            sag += gain * max(rise, 0.0) / (1.0 + gain * following)
            share = following
        rate = -1.0 / (recovery * (1.0 + gain * share))
        decay = np.exp(rate * clock.step * (np.arange(clock.substeps) + 0.5))
        pressure[period] = (supply - sag * decay) * share
        sag *= math.exp(rate * clock.period)
    stem = stem_of(dict(values), ())
    start = values["diaphragm_area"] * supply * shares[0] / values["spring_rate"]
    return stem_travel(pressure, clock, stem, (), start=start, keep_fine=False)[:, 0]


def test_supply_droop_against_small_increments():
    time, current = ramps_and_steps(seconds=4.0, seed=1)
    model = BASE.with_effect("supply_droop", droop_gain=0.3, droop_recovery_time=2.0)
    expected = droop_reference(time, current, gain=0.3, recovery=2.0)
    assert np.abs(run(model, time, current) - expected).max() < 2e-5


def test_static_maps_against_their_formulas():
    """Saturation and leak act on held values: the run is that of the mapped current or pressure."""
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    knee, width, slope = 12e-3, 1e-3, 0.7

    def ramp(x):
        return 0.5 * (x - knee + np.sqrt((x - knee) ** 2 + width**2))

    bent = current - (1.0 - slope) * (ramp(current) - ramp(0.0))
    numbers = {"saturation_slope": slope, "saturation_knee": knee, "saturation_rounding": width}
    model = BASE.with_effect("magnetic_saturation", **numbers)
    assert np.abs(run(model, time, current) - run(BASE, time, bent)).max() < 1e-12
    # Froehlich's hyperbola above the knee: x/(1 + x/b).
    left = ramp(current) / (1.0 + ramp(current) / 8e-3) - ramp(current)
    left -= ramp(0.0) / (1.0 + ramp(0.0) / 8e-3) - ramp(0.0)
    model = BASE.with_effect("magnetic_saturation", **numbers | {"saturation_slope": 0.0, "saturation_reach": 8e-3})
    assert np.abs(run(model, time, current) - run(BASE, time, current + left)).max() < 1e-12
    left = 8e-3 * (np.tanh(ramp(current) / 8e-3) - np.tanh(ramp(0.0) / 8e-3)) - ramp(current) + ramp(0.0)
    law = {"saturation_slope": 0.0, "saturation_reach": 8e-3, "saturation_law": 1.0}
    model = BASE.with_effect("magnetic_saturation", **numbers | law)
    assert np.abs(run(model, time, current) - run(BASE, time, current + left)).max() < 1e-12
    values = BASE.values
    gap = values["gap_offset"] - values["gap_gain"] * np.sqrt(current)
    pressure = values["supply_pressure"] / (1.0 + values["flow_ratio"] * gap**2)
    loss = 0.15 * np.sqrt(values["supply_pressure"])
    behind = ((-loss + np.sqrt(loss**2 + 4.0 * pressure)) / 2.0) ** 2
    leaking = run(BASE.with_effect("air_leak", leak_ratio=0.15), time, current)
    assert np.abs(leaking - run(BASE, time, behind, driven_by=1)).max() < 1e-12
    divided = run(BASE.with_effect("air_leak", leak_ratio=0.0, turbulent_leak_ratio=0.25), time, current)
    assert np.abs(divided - run(BASE, time, pressure / 1.25, driven_by=1)).max() < 1e-12


def test_readings_are_maps_of_the_position():
    time, current = ramps_and_steps(seconds=SECONDS, seed=1)
    position = run(BASE, time, current)
    coarse = run(BASE.with_effect("quantisation", resolution=2e-3, resolution_offset=3e-4), time, current)
    assert np.abs(coarse - (3e-4 + 2e-3 * np.round((position - 3e-4) / 2e-3))).max() < 1e-15
    bowed = run(BASE.with_effect("linkage_nonlinearity", linkage_bow=4e-3, linkage_skew=0.0), time, current)
    share = position / BASE.values["rated_travel"]
    assert np.abs(bowed - (position + 16e-3 * share * (1.0 - share))).max() < 1e-15


def test_a_slow_transmitter_behind_play():
    """Each closing of the play is an event; rounding must not repeat it."""
    time, current = ramps_and_steps(seconds=SECONDS, seed=2)
    keys = ("linkage_backlash", "sensor_lag")
    model = BASE.with_effect(keys[0], **CASES[keys[0]][1]).with_effect(keys[1], **CASES[keys[1]][1])
    expected = reference(BASE, time, current, [CASES[key][0] for key in keys], step=1e-6)
    assert np.abs(run(model, time, current) - expected).max() < 1e-6
