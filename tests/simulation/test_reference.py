"""The compiled chain against the valve in plain Python, which shares no code with it."""

import ast
from pathlib import Path

import numpy as np
import pytest
from simulation_runs import EFFECT_KEYS, base_model, ramps_and_steps, with_effects

import valvemodel.reference
from valvemodel.reference import simulate_slowly
from valvemodel.reference.curved import CurvedStem
from valvemodel.reference.numbers import numbers_of
from valvemodel.reference.valve import Valve
from valvemodel.simulation import simulate

EXACT_KEYS = [
    "magnetic_hysteresis", "magnetic_saturation",
    "air_leak", "choked_flow", "transport_delay",
    "static_friction", "asymmetric_friction", "asymmetric_viscous_friction", "pressure_dependent_friction",
    "area_variation", "end_stop",
    "linkage_backlash", "quantisation", "sensor_drift", "sensor_lag", "linkage_nonlinearity",
]  # fmt: skip

EXACT = 2e-14
"""Some ulp of the position: 1 ulp of 0.25 m is 5.6e-17 m, and a creep ends within 2.7e-14 m by rounding. [m]"""


def uneven(time: np.ndarray) -> np.ndarray:
    """The same rows at uneven times."""
    return time + np.random.default_rng(2).uniform(-0.009, 0.009, len(time))


def difference(model, time, current, start=float("nan")) -> float:
    found = simulate(model, time=time, current=current, start_position=start)
    expected = simulate_slowly(model, time=time, current=current, start_position=start)
    assert (found.mode == expected.mode).all()
    assert np.abs(found.pressure - expected.pressure).max() < 1e-6
    assert np.abs(found.stem_position - expected.stem_position).max() < 1e-12
    assert np.abs(found.velocity - expected.velocity).max() < 1e-9
    return float(np.abs(found.position - expected.position).max())


@pytest.mark.parametrize("damping", [612.9, 1.59])
@pytest.mark.parametrize("key", [None, *EXACT_KEYS])
def test_exact_effect_is_the_same_in_plain_python(key, damping):
    model = base_model(viscous_friction=damping)
    model = with_effects(model, key) if key else model
    time, current = ramps_and_steps(seconds=15.0, seed=1)
    assert difference(model, time, current) < EXACT
    assert difference(model, uneven(time), current) < EXACT


@pytest.mark.parametrize("seed", range(40))
def test_random_pair_of_exact_effects_is_the_same_in_plain_python(seed):
    generator = np.random.default_rng(seed)
    pair = generator.choice(EXACT_KEYS, 2, replace=False)
    model = with_effects(base_model(viscous_friction=generator.choice([1.59, 60.0, 227.0, 612.9])), *pair)
    time, current = ramps_and_steps(seconds=6.0, seed=seed)
    start = generator.uniform(0.07, 0.18)
    assert difference(model, time, current, start) < EXACT


@pytest.mark.parametrize(
    "values",
    [
        {"spring_rate": 0.0, "coulomb_friction": 4000.0},
        {"spring_rate": 0.0, "viscous_friction": 0.0, "coulomb_friction": 5000.0},
        {"coulomb_friction": 0.0},
        {"viscous_friction": 0.0},
        {"spring_preload": -900.0, "travel_min": 0.06, "travel_max": 0.2},
        {"travel_min": 0.06, "travel_max": 0.2, "restitution": 0.7},
        {"viscous_friction": 2.0 * (1.36 * 52500.0) ** 0.5},
    ],
    ids=lambda values: " ".join(values),
)
def test_odd_valve_is_the_same_in_plain_python(values):
    time, current = ramps_and_steps(seconds=10.0, seed=5)
    assert difference(base_model(**values), time, current) < 1e-13


@pytest.mark.parametrize("stop", [{}, {"stop_compliance": 2e-7}], ids=["dead", "elastic"])
def test_play_that_closes_on_the_way_to_a_stop_is_the_same_in_plain_python(stop):
    """Long periods, in which the stem takes up the play and comes to the stop in one slip."""
    model = base_model().with_effect("end_stop", upper_stop=0.13, lower_stop=0.11, **stop)
    model = model.with_effect("linkage_backlash", backlash_half_width=4e-3)
    model = model.with_effect("sensor_lag", sensor_time_constant=0.05)
    time = np.arange(12) / 20.0
    assert difference(model, time, np.where(np.arange(12) % 4 < 2, 19e-3, 5e-3)) < EXACT


INTEGRATED = (
    "coil_lag", "gap_drift", "chamber_filling", "asymmetric_filling", "supply_droop", "stribeck",
    "position_dependent_friction", "presliding", "spring_hardening", "load_force", "friction_drift",
)  # fmt: skip

OFF = 1e-9
"""How far the compiled chain may be off, at its default tolerance, from an integration at 1e-12. [m]"""

OFF_IN_PAIRS = 2e-7
"""The same for two effects at once, of which Stribeck friction magnifies what the other leaves. [m]"""


@pytest.mark.parametrize("key", INTEGRATED)
def test_integrated_effect_agrees_with_an_independent_integration(key):
    time, current = ramps_and_steps(seconds=2.0, seed=1)
    model = with_effects(base_model(), key)
    found = simulate(model, time=time, current=current).position
    expected = simulate_slowly(model, time=time, current=current).position
    assert np.abs(found - expected).max() < OFF


@pytest.mark.parametrize("seed", range(6))
def test_random_pair_with_an_integrated_effect_agrees(seed):
    generator = np.random.default_rng(seed)
    first = generator.choice(list(INTEGRATED))
    second = generator.choice([key for key in (*INTEGRATED, *EXACT_KEYS) if key not in (first, "quantisation")])
    time, current = ramps_and_steps(seconds=1.5, seed=seed)
    model = with_effects(base_model(), first, second)
    found = simulate(model, time=time, current=current).position
    expected = simulate_slowly(model, time=time, current=current).position
    assert np.abs(found - expected).max() < OFF_IN_PAIRS


@pytest.mark.parametrize("key", ["spring_hardening", "presliding"])
def test_rebound_of_a_curved_stem_agrees(key):
    time, current = ramps_and_steps(seconds=2.0, seed=1)
    bouncing = base_model(travel_min=0.08, travel_max=0.16, restitution=0.7, viscous_friction=100.0)
    model = with_effects(bouncing, key)
    found = simulate(model, time=time, current=current).position
    inelastic = simulate(model.with_values(restitution=0.0), time=time, current=current).position
    assert np.abs(found - inelastic).max() > 1e-5
    assert np.abs(found - simulate_slowly(model, time=time, current=current).position).max() < 10.0 * OFF


@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_integrated_stem_agrees_with_the_closed_form(damping):
    numbers = numbers_of(with_effects(base_model(viscous_friction=damping), "static_friction"))
    time, current = ramps_and_steps(seconds=4.0, seed=7)
    closed, integrated = Valve(numbers, current[0], float("nan")), Valve(numbers, current[0], float("nan"))
    integrated.stem = CurvedStem(numbers, integrated.stem.position)
    for start, held in zip(time.tolist(), current.tolist(), strict=True):
        closed.hold(held, start, 0.02)
        integrated.hold(held, start, 0.02)
        assert abs(closed.stem.position - integrated.stem.position) < 2e-11


def test_every_effect_is_in_one_table():
    assert {*EXACT_KEYS, *INTEGRATED} == set(EFFECT_KEYS)


def test_reference_calls_nothing_compiled():
    folder = Path(valvemodel.reference.__file__).parent
    allowed = {"valvemodel.errors", "valvemodel.model", "valvemodel.base_valve"}
    for path in folder.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("valvemodel"):
                names = {alias.name for alias in node.names}
                is_own = str(node.module).startswith("valvemodel.reference")
                assert is_own or node.module in allowed or names <= {"EFFECTS", "Setting", "Trajectory"}, path.name
