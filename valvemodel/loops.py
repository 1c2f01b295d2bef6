"""Settled loops: where the stem rests under one current after another, in closed form a step and without time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from valvemodel.compiled import compiled
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.parameters import STATE
from valvemodel.stages.bow import bow, unbow
from valvemodel.stages.electromagnet import gap_of_current, rest_electromagnet
from valvemodel.stages.nozzle import rest_nozzle
from valvemodel.stages.stem import breakaway_ratio, highest_position, lowest_position, sliding_friction

SETTLING_EFFECTS = frozenset(
    {
        "air_leak",
        "asymmetric_friction",
        "choked_flow",
        "end_stop",
        "linkage_nonlinearity",
        "magnetic_saturation",
        "static_friction",
    }
)
"""Effects with which a step still settles in closed form; others that act in a loop take the simulator and time."""

MOST_SWINGS = 100_000
"""Half swings of one step after which a stem is taken to be at rest; each loses 2 F_c / k."""

CURRENTS = 4001
"""Currents at which the map to the pressure is tabled to invert it: the error is far below any reading."""


@dataclass(frozen=True)
class LoopShape:
    """What a settled loop shows at one height: its width, its slope, its height.

    Attributes
    ----------
    position : float [m]
        Where width and slope are taken.
    width : float [A]
        Current from the falling to the rising branch, what eq. (40) estimates.
    slope : float [m/A]
        Mean slope of the two branches.
    height : float [m]
        From the rising up to the falling branch at the current in their middle; 2 F_c / k under a ramp.
    """

    position: float
    width: float
    slope: float
    height: float


def settles_in_closed_form(model: Model) -> bool:
    """Return whether each step of a settled loop of this model has a closed form."""
    has_dead_stops = model.numbers.get("stop_compliance", 0.0) == 0.0
    return has_dead_stops and set(model.effects) <= SETTLING_EFFECTS and model.values["spring_rate"] > 0.0


def settle_loop(
    model: Model, *, current: np.ndarray, start_position: float = math.nan, is_ramped: bool = False
) -> np.ndarray:
    r"""Return the reading at which the stem has settled under each current.

    The stem stays while :math:`|S_1 P - k y| \le F_s`, else it goes to :math:`(S_1 P \mp F_c)/k`. Under a stepped
    current a stem with less than critical damping overshoots by :math:`e^{-\pi\zeta/\sqrt{1 - \zeta^2}}` of its way,
    again and again until friction holds it, so that damping shows. Under a current that ramps slowly from value to
    value it is released at :math:`F_s` every time: it jumps by :math:`(F_s - F_c)/k` and its overshoot, over and over
    (stick-slip), or where it is damped too strongly to stop it slides on. With F_s = F_c a ramp shows the play
    operator, whatever the damping.

    Parameters
    ----------
    model : Model
        The base valve and `SETTLING_EFFECTS`, stops dead.
    current : array, shape (n,) [A]
    start_position : float
        Reading before the first current acts; by default in the middle of the stuck band. [m]
    is_ramped : bool
        Whether the current ramps slowly between the values, instead of stepping.

    Returns
    -------
    array, shape (n,) [m]

    Raises
    ------
    InputError
        If an effect of the model has no closed form here.

    References
    ----------
    Paper eqs. (5), (6), (16), (31) at rest; Fig. 7.
    """
    current = _checked(model, current)
    readings, pressures, modes = (np.empty((1, len(current))) for _ in range(3))
    rows = model.rows(start_position=start_position)
    settle_rows(rows, np.zeros(1, STATE), current, is_ramped, readings, pressures, modes)
    return readings[0]


def shape_of_loop(model: Model, *, position: float, highest_current: float, step: float = 0.0) -> LoopShape:
    r"""Return width, slope and height of the major loop at a position, as equal steps of the current show it.

    A stem that overshoots by a share :math:`\rho` of its way leads each branch by :math:`\rho/(1 + \rho)` of what the
    step moves it, so that a stepped loop is narrower than friction makes a ramped one.

    Parameters
    ----------
    model : Model
        As for `settle_loop`.
    position : float
        The stem's. [m]
    highest_current : float
        The branches are looked for from 0 to this. [A]
    step : float
        Of the current; 0 for a ramp. [A]
    """
    current = _checked(model, np.linspace(0.0, highest_current, CURRENTS))
    rows, pressure = model.rows(), np.empty((1, CURRENTS))
    settle_rows(rows, np.zeros(1, STATE), current, False, np.empty((1, CURRENTS)), pressure, pressure.copy())
    numbers, rate = model.numbers, model.values["spring_rate"]
    thrust = np.maximum.accumulate(numbers["diaphragm_area"] * pressure[0] - numbers["spring_preload"])
    rise = np.gradient(thrust, current)
    overshoot = overshoot_of(rows[0])
    lead = overshoot / (1.0 + overshoot) * step * rise
    asymmetry = numbers.get("friction_asymmetry", 0.0)
    rising, falling = (
        thrust - side * numbers["coulomb_friction"] * (1.0 + side * asymmetry) + side * lead for side in (1.0, -1.0)
    )
    crossed = [float(np.interp(rate * position, branch, current)) for branch in (rising, falling)]
    slope = float(np.interp(crossed, current, rise).mean()) / rate
    middle = 0.5 * (crossed[0] + crossed[1])
    height = float(np.interp(middle, current, falling - rising)) / rate
    return LoopShape(position, crossed[0] - crossed[1], slope, height)


def _checked(model: Model, current: np.ndarray) -> np.ndarray:
    if not settles_in_closed_form(model):
        others = sorted(set(model.effects) - SETTLING_EFFECTS)
        raise InputError(
            f"a settled loop has a spring and, in closed form, no effects but {', '.join(sorted(SETTLING_EFFECTS))}",
            f"the model has {', '.join(others) or 'a stop that gives way, or no spring'}",
            "hold each current for some seconds in `simulate` instead",
        )
    current = np.ascontiguousarray(current, float)
    if current.ndim != 1 or not np.all(np.isfinite(current)) or np.any(current < 0.0):
        raise InputError("currents are a row of numbers from 0 A on", f"got {current!r}", "correct them")
    return current


@compiled
def settle_rows(rows, states, currents, is_ramped, readings, pressures, modes):
    """Settle the stem of each row of numbers under one current after the other.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS
    states : array, shape (1,), dtype STATE
        Overwritten.
    currents : array, shape (m,) [A]
    is_ramped : bool
    readings, pressures, modes : arrays, shape (n, m) [m], [Pa], side of the last move
        Overwritten.
    """
    state = states[0]
    for row in range(rows.shape[0]):
        p = rows[row]
        highest, lowest = highest_position(p), lowest_position(p)
        overshoot = overshoot_of(p)
        for step in range(currents.shape[0]):
            rest_electromagnet(p, state, currents[step])
            rest_nozzle(p, state, gap_of_current(p, state.hysteresis_input, 0.0), state.hysteresis_input)
            push = p.diaphragm_area * state.pressure - p.spring_preload
            if step == 0:
                middle = push / p.spring_rate
                start = middle if math.isnan(p.start_position) else unbow(p, p.start_position)
                position = min(max(start, lowest), highest)
            before = position
            if is_ramped and step > 0:
                position = slide(p, push, position, overshoot, lowest, highest)
            else:
                position = swing(p, push, position, overshoot, lowest, highest)
            readings[row, step] = bow(p, position)
            pressures[row, step] = state.pressure
            modes[row, step] = 0.0 if position == before else math.copysign(1.0, position - before)


@compiled
def overshoot_of(p):
    """Return by which share of its way a stem overshoots, 0 from critical damping on."""
    damping = 0.5 * p.viscous_friction / math.sqrt(p.spring_rate * p.stem_mass)
    if damping >= 1.0:
        return 0.0
    return math.exp(-math.pi * damping / math.sqrt(1.0 - damping * damping))


@compiled
def released_side(p, push, position):
    """Return to which side a resting stem breaks away, 0 while friction holds it."""
    thrust = push - p.spring_rate * position
    side = math.copysign(1.0, thrust)
    held = breakaway_ratio(p) * sliding_friction(p, side, position, 0.0, 0.0)
    return side if abs(thrust) > held else 0.0


@compiled
def swing(p, push, position, overshoot, lowest, highest):
    """Return where the stem rests after a step of the current: half swings until friction holds it. [m]"""
    for _ in range(MOST_SWINGS):
        side = released_side(p, push, position)
        if side == 0.0:
            break
        goal = (push - side * sliding_friction(p, side, position, 0.0, 0.0)) / p.spring_rate
        end = min(max(goal + overshoot * (goal - position), lowest), highest)
        if overshoot == 0.0 or end == position:
            return end
        position = end
    return position


@compiled
def slide(p, push, position, overshoot, lowest, highest):
    """Return where the stem rests after a slow ramp of the current: jumps, or a slide that friction never stops. [m]"""
    side = released_side(p, push, position)
    if side == 0.0:
        return position
    friction = sliding_friction(p, side, position, 0.0, 0.0)
    excess = (breakaway_ratio(p) - 1.0) * friction
    goal = (push - side * friction) / p.spring_rate
    if overshoot > 0.0 and excess > 0.0:
        jump = (1.0 + overshoot) * excess
        beyond = side * (push - p.spring_rate * position) - friction - excess
        goal = position + side * (math.floor(beyond / jump) + 1.0) * jump / p.spring_rate
    return min(max(goal, lowest), highest)
