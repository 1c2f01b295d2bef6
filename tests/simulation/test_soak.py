"""Random valves and inputs: nothing crashes, nothing is lost, nothing runs for ever; absurd ones are refused."""

import os
import time as clock

import numpy as np
import pytest
from simulation_runs import EFFECT_KEYS, base_model, run

from identification.problem import SEARCH_TOLERANCE
from valvemodel import chain, runs
from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError
from valvemodel.parameters import MEMORY, PARAMETERS, STATE

RUNS = int(os.environ.get("VALVEMODEL_SOAK", "20000"))
"""The soak of a million is `VALVEMODEL_SOAK=1000000 pytest tests/simulation/test_soak.py`."""

AT_ONCE = 500
"""Valves that share an input."""

SLOWEST = 20e-3
"""What a run of 60 periods may take in the mean of those that share an input, on a busy machine. [s]"""

WIDE = ("stem_mass", "spring_rate", "viscous_friction", "coulomb_friction")


def random_number(generator, low, high):
    low, high = max(low, -1e6), min(high, 1e6)
    if low > 0.0 and high > 20.0 * low:
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))
    return float(generator.uniform(low, high))


def random_rows(generator) -> np.ndarray:
    """Rows of valves with wide base parameters, some with travel limits, and up to three effects each."""
    rows = base_model().rows(AT_ONCE)
    for parameter in BASE_PARAMETERS:
        if parameter.name in WIDE:
            low, high = max(parameter.low, 1e-2), min(parameter.high, 1e5)
            values = np.array([random_number(generator, low, high) for _ in rows])
            values[generator.random(AT_ONCE) < 0.1] = 0.0 if parameter.low == 0.0 else low
            chosen = generator.random(AT_ONCE) < 0.7
            rows[parameter.name][chosen] = values[chosen]
    limited = generator.random(AT_ONCE) < 0.3
    rows["travel_max"][limited] = generator.uniform(0.05, 0.2, AT_ONCE)[limited]
    rows["travel_min"][limited] = generator.uniform(-0.1, 0.04, AT_ONCE)[limited]
    for row in rows:
        for key in generator.choice(EFFECT_KEYS, int(generator.integers(0, 4)), replace=False):
            effect = effect_of_key(str(key))
            for parameter in effect.parameters:
                typical = effect.typical[parameter.name]
                is_drawn = generator.random() < 0.8
                row[parameter.name] = random_number(generator, parameter.low, parameter.high) if is_drawn else typical
    return rows


def random_input(generator) -> tuple[np.ndarray, np.ndarray]:
    count = 60
    period = float(np.exp(generator.uniform(np.log(1e-3), np.log(5.0 if generator.random() < 0.1 else 0.05))))
    time = period * np.arange(count)
    if generator.random() < 0.3:
        time = np.cumsum(period * generator.uniform(0.2, 3.0, count))
    current = 12e-3 + 8e-3 * np.sin(2.0 * np.pi * np.arange(count) / generator.uniform(3, 200))
    if generator.random() < 0.5:
        current = generator.uniform(0.0, 24e-3, count)
    return time, current


def test_random_valves_and_inputs():
    run(base_model(), np.arange(3.0), np.full(3, 0.01))  # compiles
    for number in range(-(-RUNS // AT_ONCE)):
        generator = np.random.default_rng([20, number])
        rows = random_rows(generator)
        time, current = random_input(generator)
        found = np.empty((AT_ONCE, len(time)))
        began = clock.perf_counter()
        runs.run_chain(
            rows, np.zeros(AT_ONCE, STATE), np.zeros(1, MEMORY), time, current, runs.FREE, chain.CURRENT,
            SEARCH_TOLERANCE, found, runs.NONE, runs.NONE,
        )  # fmt: skip
        took = clock.perf_counter() - began
        lost = np.flatnonzero(~np.isfinite(found).all(axis=1))
        assert len(lost) == 0, (number, {name: rows[lost[0]][name] for name in PARAMETERS.names})
        assert took < SLOWEST * AT_ONCE, (number, took)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("stem_mass", 0.0), ("stem_mass", -1.0), ("stem_mass", float("nan")), ("spring_rate", -1.0),
        ("viscous_friction", -0.1), ("coulomb_friction", -5.0), ("diaphragm_area", 0.0),
        ("supply_pressure", -3e5), ("supply_pressure", float("inf")), ("travel_min", float("inf")),
    ],
)  # fmt: skip
def test_absurd_valves_are_refused_with_rule_and_value(name, value):
    with pytest.raises(InputError, match=name):
        base_model(**{name: value})


def test_breakaway_below_coulomb_friction_is_refused():
    with pytest.raises(InputError, match="static_friction_ratio"):
        base_model().with_effect("static_friction", static_friction_ratio=0.9)
