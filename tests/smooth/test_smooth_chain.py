"""The smooth chain becomes the exact simulator as the width goes to 0, for every effect that has a smooth form."""

import casadi as ca
import numpy as np
import pytest

from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.simulation import simulate
from valvemodel.smooth.chain import WITHOUT_SMOOTH_FORM, SmoothChain, parts_for, run_smooth
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

RATE, SECONDS = 100.0, 24.0
NEEDED = {
    "end_stop": {"upper_stop": 0.19},
    "load_force": {"load_sine": 200.0, "load_cosine": 100.0, "load_period": 5.0},
    "position_dependent_friction": {
        "tight_spot_excess": 0.6,
        "tight_spot_position": 0.12,
        "tight_spot_exponent": 2.6,
        "tight_spot_closure": 0.4,
    },
}
KEYS = [effect.key for effect in EFFECTS if effect.key != "quantisation"]

LEFT_OVER = {
    # What a part takes as straight, at 10 ms; it falls with more parts.
    "coil_lag": 5e-5, "chamber_filling": 5e-5, "asymmetric_filling": 5e-5, "spring_hardening": 2e-5,
    "sensor_lag": 2e-5, "position_dependent_friction": 2e-4,
    # Bristles that ring ratchet in the exact run; the smooth one takes them as settled.
    "presliding": 1e-3,
    # A breakaway that is decided by a hair.
    "stribeck": 8e-3,
}  # fmt: skip
"""Root mean square off the exact run that no width removes [m]; others are below a micrometre at 0.1 N."""


def base(**values: float) -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, {**valve.values, **values})


def with_effect(key: str) -> Model:
    return base().with_effect(key, **NEEDED.get(key, {}))


def profile() -> tuple[np.ndarray, np.ndarray]:
    """A triangle, then steps. [s], [A]"""
    time = np.arange(int(SECONDS * RATE) + 1) / RATE
    triangle = np.interp(time % 12.0, [0.0, 6.0, 12.0], [5e-3, 19e-3, 5e-3])
    steps = np.repeat(np.random.default_rng(0).uniform(5e-3, 19e-3, len(time) // 60 + 1), 60)[: len(time)]
    return time, np.where(time < 12.0, triangle, steps)


TIME, CURRENT = profile()


def apart(model: Model, width: float, parts: int | None = None) -> np.ndarray:
    """Smooth less exact readings. [m]"""
    exact = simulate(model, time=TIME, current=CURRENT, start_position=0.02)
    chain = SmoothChain(model, parts=parts or parts_for(model, 1.0 / RATE))
    return run_smooth(chain, time=TIME, current=CURRENT, start_position=0.02, width=width) - exact.position


@pytest.mark.parametrize("damping", [1.59, 60.0, 612.9, 3000.0])
def test_base_valve_converges_to_the_exact_run_with_the_width(damping):
    model = base(viscous_friction=damping)
    largest = [np.abs(apart(model, width)).max() for width in (10.0, 1.0, 0.1, 1e-3)]
    assert largest[0] < 5e-4
    assert largest[1] < 6e-5
    assert largest[2] < 6e-6
    assert largest[3] < 1e-7


def test_a_swinging_stem_is_cut_so_that_it_stops_once_in_a_part():
    assert parts_for(base(viscous_friction=1.59), 0.01) == 2
    assert parts_for(base(), 0.01) == 1
    assert parts_for(with_effect("coil_lag"), 0.01) == 2


@pytest.mark.parametrize("key", KEYS)
def test_effects_converge_to_the_exact_run(key):
    model = with_effect(key)
    wide, narrow = (float(np.sqrt(np.mean(apart(model, width) ** 2))) for width in (30.0, 0.1))
    assert narrow < LEFT_OVER.get(key, 2e-6)
    assert narrow <= wide * 1.001


LAWS = [{"bristle_damping": 400.0}, {"bristle_exponent": 1.4}, {"slider_share": 1.0}]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: next(iter(law)))
def test_every_law_of_presliding_is_close_to_the_exact_run_on_a_triangle(law):
    model, plain = (base().with_effect("presliding", presliding_compliance=2e-6, **each) for each in (law, {}))
    triangle = TIME < 12.0
    off = apart(model, 0.1, parts=8)[triangle]
    with_law, without = (simulate(each, time=TIME, current=CURRENT, start_position=0.02) for each in (model, plain))
    change = (with_law.position - without.position)[triangle]
    left_over, size = (float(np.sqrt(np.mean(each**2))) for each in (off, change))
    assert left_over < 0.85 * size
    assert left_over < 0.5 * LEFT_OVER["presliding"]


TANH = {"saturation_slope": 0.0, "saturation_knee": 8e-3, "saturation_reach": 15e-3, "saturation_law": 1.0}
GAS = {"chamber_filling_time": 0.15, "filling_of_gas": 1.0}
LEAKS_GAS = {"leak_ratio": 0.05, "turbulent_leak_ratio": 0.2, "leak_chokes": 1.0}


@pytest.mark.parametrize(("key", "law"), [("air_leak", LEAKS_GAS), ("magnetic_saturation", TANH)])
def test_later_laws_converge_to_the_exact_run(key, law):
    assert np.sqrt(np.mean(apart(base().with_effect(key, **law), 0.1) ** 2)) < 2e-6


@pytest.mark.parametrize(
    ("key", "law"), [("air_leak", LEAKS_GAS), ("magnetic_saturation", TANH), ("chamber_filling", GAS)]
)
def test_derivatives_of_a_step_by_later_laws_agree_with_differences(key, law):
    check_derivatives(base().with_effect(key, **law))


def test_sliders_slide_where_friction_falls_with_the_pressure():
    model = base(viscous_friction=3000.0).with_effect("presliding", presliding_compliance=2e-6, slider_share=1.0)
    off = apart(model.with_effect("pressure_dependent_friction", friction_area=0.01), 0.1, parts=16)[TIME < 12.0]
    assert np.sqrt(np.mean(off**2)) < 1e-6


@pytest.mark.parametrize("key", ["coil_lag", "chamber_filling", "spring_hardening", "sensor_lag"])
def test_what_a_part_takes_as_straight_falls_with_the_parts(key):
    model = with_effect(key)
    coarse, fine = (np.sqrt(np.mean(apart(model, 0.01, parts) ** 2)) for parts in (2, 8))
    assert fine < 0.3 * coarse


@pytest.mark.parametrize("key", KEYS)
def test_an_effect_at_its_neutral_values_is_absent(key):
    neutral = {each.name: each.neutral for each in effect_of_key(key).parameters}
    given = {"time": TIME, "current": CURRENT, "start_position": 0.02, "width": 1.0}
    # Where the neutral effect asks for finer parts, the plain chain is cut alike.
    parts = parts_for(with_effect(key), 1.0 / RATE)
    plain = run_smooth(SmoothChain(base(), parts=parts), **given)
    found = run_smooth(SmoothChain(base().with_effect(key, **neutral), parts=parts), **given)
    assert np.abs(found - plain).max() < (2e-5 if key == "presliding" else 1e-9)


@pytest.mark.parametrize("key", [None, *(key for key in KEYS if key not in WITHOUT_SMOOTH_FORM)])
def test_derivatives_of_a_step_agree_with_differences(key):
    check_derivatives(base() if key is None else with_effect(key))


TWO_LAGS = [(0.1, 0.03), (0.03, 0.1), (0.06, 0.06), (0.0, 0.05)]
LAGS = {
    "sensor_lag": ("sensor_time_constant", "sensor_second_time_constant"),
    "coil_lag": ("coil_time_constant", "eddy_time_constant"),
}


def with_two_lags(key: str, pair: tuple[float, float]) -> Model:
    return base().with_effect(key, **dict(zip(LAGS[key], pair, strict=True)))


@pytest.mark.parametrize("pair", TWO_LAGS)
@pytest.mark.parametrize("key", LAGS)
def test_two_lags_in_series_converge_to_the_exact_run(key, pair):
    off = apart(with_two_lags(key, pair), 0.1)
    assert np.sqrt(np.mean(off**2)) < LEFT_OVER[key]


@pytest.mark.parametrize("pair", TWO_LAGS)
@pytest.mark.parametrize("key", LAGS)
def test_derivatives_of_a_step_behind_two_lags_agree_with_differences(key, pair):
    check_derivatives(with_two_lags(key, pair))


WORN = {"backlash_half_width": 3e-3, "backlash_start": 0.5, "backlash_wear": 0.4}


def test_worn_joint_converges_to_the_exact_run():
    off = apart(base().with_effect("linkage_backlash", **WORN), 1e-2)
    assert np.sqrt(np.mean(off**2)) < 2e-7


def test_derivatives_of_a_step_behind_a_worn_joint_agree_with_differences():
    check_derivatives(base().with_effect("linkage_backlash", **WORN))


def test_derivatives_of_a_step_on_sliders_and_curved_bristles_agree_with_differences():
    law = {"bristle_damping": 400.0, "bristle_exponent": 1.4, "slider_share": 0.5}
    check_derivatives(base().with_effect("presliding", presliding_compliance=2e-6, **law))


def check_derivatives(model: Model) -> None:
    chain = SmoothChain(model)
    p = chain.values(30.0)
    states = [chain.start(0.1, 12e-3, p).full().ravel()]
    for current in (12e-3, 15e-3, 15.1e-3, 15.2e-3, 9e-3, 9.05e-3):
        states.append(chain.step(states[-1], [current, 0.01], p).full().ravel())
    slopes = chain.step.jacobian()
    compared = 0
    for state in states[2:]:
        u = np.array([14e-3, 0.01])
        exact = np.hstack([block.full() for block in slopes(state, u, p, chain.step(state, u, p))])
        given = np.concatenate([state, u, p])
        sizes = np.concatenate([scale_of(chain), [1e-3, 1e-2], np.maximum(np.abs(p), 1e-9)])
        for column, size in enumerate(sizes):
            coarse, fine = (difference(chain, given, column, size * step) for step in (1e-4, 1e-5))
            scale = np.abs(fine) + 1e-6 * np.abs(exact).max(axis=1) + 1e-12 / size
            if (np.abs(coarse - fine) < 1e-3 * scale).all():
                assert np.abs(exact[:, column] - fine).max() < 2e-3 * scale.max(), chain.parameters
                compared += 1
    assert compared > 2 * len(sizes)


def scale_of(chain: SmoothChain) -> np.ndarray:
    """Size of each state. [SI]"""
    sizes = {
        "position": 0.1,
        "velocity": 0.1,
        "linkage": 0.1,
        "tight_linkage": 0.1,
        "loose_linkage": 0.1,
        "lagged_reading": 0.1,
        "bristle": 1e3,
        "time": 1.0,
    }
    return np.array([1e5 if "pressure" in name or name == "droop" else sizes.get(name, 1e-2) for name in chain.states])


def difference(chain: SmoothChain, given: np.ndarray, column: int, step: float) -> np.ndarray:
    """Central difference of a step in one number of (x, u, p)."""
    count = len(chain.states)

    def at(shift: float) -> np.ndarray:
        moved = given.copy()
        moved[column] += shift
        return chain.step(moved[:count], moved[count : count + 2], moved[count + 2 :]).full().ravel()

    return (at(step) - at(-step)) / (2.0 * step)


def test_second_derivatives_are_those_of_the_first():
    chain = SmoothChain(base())
    x, u, p = chain.start(0.1, 12e-3, chain.values(30.0)), [15e-3, 0.01], chain.values(30.0)
    force = chain.parameters.index("coulomb_friction")
    given = ca.MX.sym("p", len(p))
    position = chain.step(x, u, given)[chain.states.index("position")]
    hessian = ca.Function("hessian", [given], [ca.hessian(position, given)[0][:, force]])(p).full().ravel()
    gradient = ca.Function("gradient", [given], [ca.gradient(position, given)])
    step = np.zeros(len(p))
    step[force] = 1e-2
    differences = (gradient(p + step).full() - gradient(p - step).full()).ravel() / 2e-2
    assert hessian == pytest.approx(differences, rel=1e-5, abs=1e-12)


def test_affine_valves_have_a_smooth_chain_too():
    valve = read_valve("linear")
    assert np.abs(apart(Model(valve.name, valve.values), 0.1)).max() < 3e-6


STOPS_THAT_YIELD = [{"upper_stop": 0.19}, {"upper_stop": 0.17, "lower_stop": 0.09}]


@pytest.mark.parametrize("stops", STOPS_THAT_YIELD, ids=" ".join)
@pytest.mark.parametrize("compliance", [2e-9, 2e-7])
def test_a_stop_that_gives_way_is_as_deep_as_in_the_exact_run(stops, compliance):
    model = base().with_effect("end_stop", **stops, stop_compliance=compliance)
    ramps = (TIME > 1.0) & (TIME < 12.0)
    off, depth = apart(model, 1e-3), 5.0 * compliance * model.values["coulomb_friction"]
    # A stem that comes to a stop fast is taken to rest there within a part.
    assert np.abs(off[ramps]).max() < 0.05 * depth + 3e-6
    # One that leaves it is thrown by it; the smooth form only lets it go.
    assert np.sqrt(np.mean(off[TIME > 1.0] ** 2)) < 0.1 * depth + 3e-5


def test_derivatives_of_a_step_against_a_stop_that_gives_way_agree_with_differences():
    check_derivatives(base().with_effect("end_stop", upper_stop=0.13, lower_stop=0.12, stop_compliance=2e-6))
