"""Drifts held for a period: what changes so slowly that a coarse run takes it in steps.

Gap, load and friction may change while the current is held, and then no closed form holds. Where a stem would come less
than the tolerance too late, under a load by root mean square, they stand still in each period at its middle value.
"""

from __future__ import annotations

import math

from valvemodel.compiled import compiled
from valvemodel.stages.electromagnet import gap_drift
from valvemodel.stages.load import has_load, load, usual_slope
from valvemodel.stages.motion import plan_friction
from valvemodel.stages.part import is_coarse
from valvemodel.stages.stem import friction_drift, friction_growth, varies_in_time

STEEPEST = 3.0 * math.sqrt(3.0) / 8.0
"""Steepest fall of 1/(x^2 + 1), where x^2 = 1/3: of eq. (16) in the gap."""

LATE_UNDER_LOAD = 0.5
"""What a stem under a held load is late by in root mean square, over what its usual slope gives: it also rests."""


@compiled
def has_drifts(p):
    """Return whether gap, load or friction change while the current is held."""
    return varies_in_time(p) or p.gap_drift_rate != 0.0


@compiled
def may_hold_drifts(p, period, tolerance):
    """Return whether a run with periods of at most so long takes what drifts in steps."""
    if not (is_coarse(tolerance) and has_drifts(p)):
        return False
    # A gap drifts fastest at the start.
    pull = p.diaphragm_area * STEEPEST * p.supply_pressure * math.sqrt(p.flow_ratio)
    fastest = LATE_UNDER_LOAD * usual_slope(p) + friction_drift(p) + pull * abs(p.gap_drift_rate)
    return late_by(p, period) * fastest <= tolerance * p.spring_rate


@compiled
def late_by(p, period):
    """Return by how much a slipping stem is late at a sample where a force that rises is held at its middle value. [s]

    A stem without mass follows a ramp late by f_v/k; the steps that stand for it come half a period and what is left of
    the last step late.
    """
    if p.viscous_friction <= 0.0 or p.spring_rate <= 0.0:
        return 0.5 * period
    follows = p.viscous_friction / p.spring_rate
    fade = math.exp(-period / follows)
    return 0.5 * period + period * fade / (1.0 - fade) - follows


@compiled
def longest_period(time):
    """Return the longest time between two samples. [s]"""
    longest = 0.0
    for sample in range(time.shape[0] - 1):
        longest = max(longest, time[sample + 1] - time[sample])
    return longest


@compiled
def take_out_drifts(p):
    """Let nothing drift by itself in the numbers of a run."""
    p.gap_drift_rate = p.load_sine = p.load_cosine = p.friction_drift_rate = 0.0
    p.load_waves = 1.0


@compiled
def hold_drifts(p, state, given, time):
    """Write into the numbers of a run what those given come to at an instant."""
    if given.gap_drift_rate != 0.0:
        p.gap_offset = given.gap_offset + gap_drift(given, time)
        state.rest_drive = math.nan
    if has_load(given):
        p.spring_preload = given.spring_preload - load(given, time)
    if given.friction_drift_rate != 0.0:
        growth = friction_growth(given, time)
        p.coulomb_friction = given.coulomb_friction * growth
        p.friction_area = given.friction_area * growth
        plan_friction(p, state)
