"""One compiled record holds every number of a valve and of all effects, made from the declarations."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from valvemodel.base_valve import BASE_PARAMETERS, ON_PRESSURE
from valvemodel.stages import EFFECTS
from valvemodel.stages.kept_parts import KEPT, MOST_KEPT
from valvemodel.stages.lag import LAGS
from valvemodel.stages.line import CAPACITY
from valvemodel.stages.nodes import NODES, ORDER, REMEMBERED
from valvemodel.stages.plays import PLAYS
from valvemodel.stages.sliders import SLIDERS

_HERE = Path(__file__).parent
_COMPILED = (
    *sorted((_HERE / "stages").glob("*.py")),
    _HERE / "chain.py",
    _HERE / "loops.py",
    _HERE / "runs.py",
    _HERE / "stepping.py",
    _HERE / "equations" / "numeric.py",
    *sorted((_HERE / "control" / "laws").glob("*.py")),
    _HERE / "linear" / "rates.py",
)


def _fingerprint() -> str:
    """Name the state of the compiled sources, so that a change in any of them makes a new type and no stale cache."""
    digest = hashlib.sha256()
    for path in _COMPILED:
        digest.update(path.read_bytes())
    return f"sources_{digest.hexdigest()[:12]}"


EFFECT_PARAMETERS = tuple(parameter for effect in EFFECTS for parameter in effect.parameters)
PARAMETERS = np.dtype(
    [(parameter.name, "f8") for parameter in BASE_PARAMETERS + EFFECT_PARAMETERS]
    + [(name, "f8") for name in ("start_position", "anchor_tolerance", "anchors_at_rest", _fingerprint())]
)
"""Type of the record of numbers that the compiled chain reads."""

ACT_ON_PRESSURE = ON_PRESSURE + tuple(
    parameter.name for effect in EFFECTS if effect.acts_on_pressure for parameter in effect.parameters
)
"""Names of the numbers that act on the pressure; all others act behind it."""

STATE = np.dtype(
    [
        (name, "f8")
        for name in (
            "flux_current", "less_lagged_flux", "hysteresis", "hysteresis_input",
            "droop", "share", "chamber_pressure", "filled_pressure", "pressure",
            "part_aim", "aim_after_rise", "aim_after_fall", "held_drive", "rest_drive",
            "position", "velocity", "mode", "bristle", "trial_step",
            "linkage", "tight_linkage", "loose_linkage", "lagged_reading", "less_lagged_reading",
            "plan_linear", "plan_elastic", "plan_varies", "plan_limit_held", "plan_closed", "plan_response",
            "plan_series", "plan_bowed", "plan_plain", "plan_clear", "plan_reach", "plan_glides", "plan_steady",
            "plan_falling", "plan_share",
            "plan_moving", "plan_current", "plan_delayed", "plan_longest",
            "plan_highest", "plan_lowest", "plan_rising_friction", "plan_falling_friction", "plan_ratio", "plan_drift",
            "plan_hard_stop", "span_highest", "span_lowest",
            "quiet_duration", "quiet_side", "quiet_vv", "quiet_vf", "quiet_yv", "quiet_yf",
            "quiet_yy", "quiet_vy", "quiet_friction",
            "known_damping", "known_stiffness", "known_duration", "known_alpha", "known_beta", "known_half_swing",
            "known_vv", "known_va", "known_av", "known_aa", "known_yv", "known_ya",
            "trace_damping", "trace_stiffness", "trace_steady", "trace_velocity", "trace_acceleration",
            "trace_next_velocity", "trace_next_acceleration", "lag_duration", "lag_decay",
            "shorter_lag_decay",
        )
    ]
    + [("plays", "f8", (PLAYS,)), ("radii", "f8", (PLAYS,)), ("sliders", "f8", (SLIDERS,))]
)  # fmt: skip
"""Type of the state that the compiled chain carries from period to period."""

SAMPLE = np.dtype([(name, "f8") for name in ("reading", "pressure", "position", "velocity", "mode")])
"""Type of what stands at an instant."""

EVENT = np.dtype([(name, "f8") for name in ("time", "position", "speed_before", "mode_before", "mode_after")])
"""Type of a change of mode: its instant, the stem's position, the speed just before it, the modes around it."""

MOST_NOTED = 4096
"""Events that one period can leave behind."""

_ROW, _TABLE = (NODES + 1,), (NODES + 1, NODES + 1)

LAG = np.dtype([("rate", "f8"), ("spacing", "f8"), ("count", "f8"), ("decay", "f8", _ROW), ("response", "f8", _TABLE)])
"""Type of what is known of a first-order lag over the nodes of a part."""

RESPONSE = np.dtype(
    [
        ("damping", "f8"), ("stiffness", "f8"), ("spacing", "f8"), ("count", "f8"),
        ("impulse", "f8", _ROW), ("rate", "f8", _ROW), ("doubled", "f8", _ROW), ("way", "f8", _TABLE),
    ]
)  # fmt: skip
"""Type of what is known of a linear slip over the nodes of a step."""

GLIDE = np.dtype([(name, "f8") for name in ("duration", "side", "vv", "vf", "yv", "yf", "yy", "vy")])
"""Type of what is known of a glide over a duration of one slip."""

MEMORY = np.dtype(
    [
        ("line_entered", "f8"),
        ("line_acting", "f8"),
        ("line_time", "f8", (CAPACITY,)),
        ("line_drive", "f8", (CAPACITY,)),
        ("notes_events", "f8"),
        ("events_noted", "f8"),
        ("events", EVENT, (MOST_NOTED,)),
        ("lags", LAG, (LAGS, REMEMBERED)),
        ("lag_turns", "f8", (LAGS,)),
        ("responses", RESPONSE, (REMEMBERED,)),
        ("glides", GLIDE, (REMEMBERED,)),
        ("kept", KEPT, (MOST_KEPT,)),
    ]
    + [
        (name, "f8")
        for name in (
            "part_time", "part_spacing", "part_count",
            "end_flux", "end_less_lagged_flux", "end_input", "end_hysteresis",
            "end_share", "end_supply", "end_supplied", "end_chamber", "end_filled",
            "step_time", "step_spacing", "step_count", "step_side", "step_position", "step_speed",
            "step_start", "step_damping", "step_stiffness", "trace_count", "bristles_off",
            "response_place", "response_turn", "glide_turn",
            "takes_parts", "parts_kept", "parts_taken", "kept_plan",
        )
    ]
    + [
        (name, "f8", _ROW)
        for name in (
            "part_powers", "currents", "gaps", "pressures", "shares",
            "step_pressures", "ways", "speeds", "pulls", "pull_powers", "bristles", "slid", "limits",
            "limits_behind", "feeds", "forces", "values", "powers",
        )
    ]
    + [
        (name, "f8", (ORDER + 1,))
        for name in ("series_ways", "series_rates", "series_changes", "series_fades", "series_forces")
    ]
)  # fmt: skip
"""Type of what a run remembers beside its state: the drives under way in the line, the events of the period, what is
known of the responses at the nodes of the last part and step, the parts of a run that serve others."""


def parameter_rows(values: Mapping[str, float], count: int = 1) -> np.ndarray:
    """Make equal rows of numbers, neutral but for the given values.

    Parameters
    ----------
    values : mapping of parameter name to SI value
        `start_position` may be among them (a reading); NaN or absent means at rest in the middle of the stuck band.
        `anchor_tolerance` is how far a run may be off an anchor without being put anew; 0 where absent. [m]
        `anchors_at_rest` is 1 where only a stem that has just come to rest is put anew; 0 where absent.
    count : int
        Number of rows.

    Returns
    -------
    array, shape (count,), dtype PARAMETERS
    """
    rows = np.zeros(count, PARAMETERS)
    for parameter in BASE_PARAMETERS + EFFECT_PARAMETERS:
        rows[parameter.name] = values.get(parameter.name, parameter.neutral)
    rows["start_position"] = values.get("start_position", np.nan)
    rows["anchor_tolerance"] = values.get("anchor_tolerance", 0.0)
    rows["anchors_at_rest"] = values.get("anchors_at_rest", 0.0)
    return rows


_COLUMNS = np.array([list(PARAMETERS.fields or ()).index(name) for name in ACT_ON_PRESSURE])


def one_by_one(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the order of so many rows each of which lays its own pressure, as `by_pressure` does."""
    return np.arange(count), np.zeros(count, bool)


def by_pressure(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order rows of numbers so that those with the same pressures come after each other.

    Parameters
    ----------
    rows : array, shape (n,), dtype PARAMETERS

    Returns
    -------
    order : array of int, shape (n,)
        Places of the rows.
    follows : array of bool, shape (n,)
        Whether a row, in that order, differs from the one before it behind the pressure alone.
    """
    order, follows = one_by_one(len(rows))
    if len(rows) == 1:
        return order, follows
    numbers = np.ascontiguousarray(rows).view("f8").reshape(len(rows), -1)[:, _COLUMNS]
    differing = numbers[:, (numbers != numbers[0]).any(axis=0)]
    if differing.size:
        order = np.lexsort(differing.T)
    follows[1:] = (differing[order[1:]] == differing[order[:-1]]).all(axis=1)
    return order, follows
