"""The base valve of a plant: its parameters, spread about the nominal ones, and its integration."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from diagnosis.blindtest.chain.clock import Clock, Signal, clock_of
from diagnosis.blindtest.chain.electromagnet import gap
from diagnosis.blindtest.chain.nozzle import ATMOSPHERE, chamber_pressure, relative_flow
from diagnosis.blindtest.chain.sensor import needs_fine_travel, reading
from diagnosis.blindtest.chain.stem import load_force, resting_travel, stem_of, stem_travel
from diagnosis.blindtest.truth import Truth, by_effect

FINE_STEP = 2.5e-5  # s; halving it moves a record by less than a tenth of its resolution
LOW_CURRENT, HIGH_CURRENT = 4e-3, 20e-3  # A

# Design, section 2, valve set `calibrated`. SI units.
NOMINAL: dict[str, float] = {
    "stem_mass": 1.36,
    "spring_rate": 52500.0,
    "diaphragm_area": 0.0645,
    "supply_pressure": 3e5,
    "viscous_friction": 612.9,
    "coulomb_friction": 1423.0,
    "spring_preload": 0.0,
    "flow_ratio": 1.0437e9,
    "gap_offset": 126.30e-6,
    "gap_gain": 750.1e-6,
}

# Part by which a parameter is spread either way.
SPREAD = {
    "stem_mass": 0.2,
    "spring_rate": 0.15,
    "diaphragm_area": 0.05,
    "supply_pressure": 0.03,
    "viscous_friction": 0.3,
    "coulomb_friction": 0.4,
}
LOW_PRESSURE, HIGH_PRESSURE = (36e3, 45e3), (195e3, 220e3)  # Pa at 4 and 20 mA


def draw_base(generator: np.random.Generator, choked: Truth | None = None) -> dict[str, float]:
    """Base parameters about the nominal ones; 4 to 20 mA gives roughly 40 to 210 kPa.

    Where the flow is choked, the gap's two numbers are those that give this range with choked flow.
    """
    base = dict(NOMINAL)
    for name, part in SPREAD.items():
        base[name] *= float(np.exp(generator.uniform(-part, part)))
    scale = base["supply_pressure"] / NOMINAL["supply_pressure"]
    pressures = scale * np.array([generator.uniform(*LOW_PRESSURE), generator.uniform(*HIGH_PRESSURE)])
    return base | _gap_numbers(pressures, base, choked)


def _gap_numbers(pressures: Signal, base: Mapping[str, float], choked: Truth | None) -> dict[str, float]:
    """Gap offset and gain for which 4 and 20 mA give two pressures."""
    supply = base["supply_pressure"]
    if choked is None:
        area_ratio = np.sqrt(supply / pressures - 1.0)
    else:
        inside, source = pressures + ATMOSPHERE, supply + ATMOSPHERE
        supplied = source * relative_flow(inside / source, choked)
        area_ratio = supplied / (inside * relative_flow(ATMOSPHERE / inside, choked))
    wide, narrow = area_ratio / np.sqrt(base["flow_ratio"])
    gain = (wide - narrow) / (np.sqrt(HIGH_CURRENT) - np.sqrt(LOW_CURRENT))
    return {"gap_offset": float(wide + gain * np.sqrt(LOW_CURRENT)), "gap_gain": float(gain)}


def integrate(
    base_params: Mapping[str, float],
    time: Signal,
    current: Signal,
    *,
    step: float = FINE_STEP,
    effects: tuple[Truth, ...] = (),
    start_position: float | None = None,
    start_share: float = 0.0,
) -> dict[str, Signal]:
    """Integrate a valve from rest with a small fixed step, without noise.

    Parameters
    ----------
    base_params : mapping
        Base parameters by name, as in `NOMINAL`; `travel_min` and `travel_max` may be added. SI units.
    time, current : arrays, shape (n,)
        Uniform sample times [s] and the current held from each to the next [A].
    step : float
        Longest fine step. [s]
    effects : tuple of Truth
        What is in the valve beyond the base model.
    start_position : float, optional
        Travel of the stem at rest [m]; without it, where friction carries `start_share` of its
        breakaway value (0: the middle of the stuck band).

    Returns
    -------
    dict
        `time` [s], `current` [A], `pressure` [Pa], `position` (the sensor's reading) [m],
        `travel` (the stem's) [m], each of shape (n,): the state just before the period's input acts.
    """
    time, current = np.asarray(time, dtype=float), np.asarray(current, dtype=float)
    clock = clock_of(time, step)
    opening = gap(current, clock, base_params, effects)
    pressure = chamber_pressure(opening, clock, base_params, effects)
    if start_position is None:
        start_position = _resting_position(pressure, clock, base_params, effects, start_share)
    stem = stem_of(base_params, effects)
    keep_fine = needs_fine_travel(effects)
    travel = stem_travel(pressure, clock, stem, effects, start=start_position, keep_fine=keep_fine)
    return {
        "time": time,
        "current": current,
        "pressure": _before_input(pressure),
        "position": reading(travel, clock, effects),
        "travel": travel[:, 0].copy(),
    }


def _resting_position(pressure: Signal, clock: Clock, base: Any, effects: Any, share: float) -> float:
    """Travel at rest before the first period. [m]"""
    load = float(load_force(clock, effects)[0])
    return resting_travel(stem_of(base, effects), float(pressure[0, 0]), load, share)


def _before_input(pressure: Signal) -> Signal:
    """Pressure at the end of the period before, shape (periods,). [Pa]"""
    return np.concatenate([pressure[:1, 0], pressure[:-1, -1]])


def choked_truth(effects: tuple[Truth, ...]) -> Truth | None:
    """The choked flow among the effects, if it is there."""
    return by_effect(effects, "nozzle").get("choked_flow")
