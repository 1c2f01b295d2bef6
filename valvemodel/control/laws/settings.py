"""Settings of a controller, declared once: one compiled record holds those of every law."""

from __future__ import annotations

import math

import numpy as np

from valvemodel.declarations import Parameter
from valvemodel.parameters import PARAMETERS

LOWEST_CURRENT, HIGHEST_CURRENT = 4e-3, 20e-3
"""Range of the live-zero current loop, Table 1; no law leaves it. [A]"""

PID, KNOCKER, REINFORCEMENT, TWO_MOVES, LANDING = range(5)
"""Laws. Self-calibration and SC-PID are PID around a feedforward."""

HELD, BRANCH_LINE, MEAN_LINE, MODEL_BRANCH = range(4)
"""Feedforwards: the current at the start, the calibrated line read in two ways, the branches of a model."""

TABLE_LENGTH = 129
"""Points of a table of currents over the travel; on `calibrated` they leave an error of 2 um."""

SETTING_PARAMETERS = (
    Parameter("period", "s", "controller period", 1e-4, 10.0, 0.01, scale="log"),
    Parameter("proportional_gain", "A/m", "K_P of (34)", 0.0, 1e3, 0.0),
    Parameter("integral_gain", "A/(m*s)", "K_I of (34) is this times the period", 0.0, 1e4, 0.0),
    Parameter("derivative_gain", "A*s/m", "K_D of (34) is this over the period", 0.0, 1e3, 0.0),
    Parameter("start_current", "A", "what the output of (34) is added to", 0.0, 0.02, 0.0),
    Parameter("dead_band", "m", "error up to which nothing is integrated or compensated", 0.0, 1.0, 0.0),
    Parameter("rate_limit", "A/s", "fastest change of the current", 0.0, math.inf, math.inf),
    Parameter("line_slope", "m/A", "k of (37)", 0.0, 1e3, 1.0),
    Parameter("rising_intercept", "m", "b_1 of (38)", -10.0, 10.0, 0.0),
    Parameter("falling_intercept", "m", "b_2 of (39)", -10.0, 10.0, 0.0),
    Parameter("threshold_share", "1", "share of I_threshold of (40) added each way from the mean line", 0.0, 1.0, 0.5),
    Parameter("knock_amplitude", "A", "height of a pulse", 0.0, 0.016, 0.0),
    Parameter("knock_width", "s", "length of a pulse", 0.0, 10.0, 0.0),
    Parameter("knock_interval", "s", "time from pulse to pulse", 0.0, 100.0, 0.0),
    Parameter("reinforcement", "A", "added in the direction in which the output changes", 0.0, 0.016, 0.0),
    Parameter("first_move", "A", "by how much the first of two moves exceeds the branch", 0.0, 0.016, 0.0),
    Parameter("move_duration", "s", "for how long each of two moves is held", 0.0, 100.0, 0.0),
    Parameter("still_duration", "s", "error beyond the dead band for so long asks for two moves", 0.0, 100.0, 0.0),
    Parameter("dwell", "s", "time from a landing to the judgement of it", 0.0, 100.0, 0.0),
    Parameter("slip_jump", "m", "shortest slip: breakaway less sliding friction over the spring rate", 0.0, 1.0, 0.0),
    Parameter("table_low", "m", "first position of the tables of currents", -10.0, 10.0, 0.0),
    Parameter("table_step", "m", "distance of their positions", 0.0, 1.0, 1.0),
)
"""Numbers of all laws; a law reads those that it needs. Gains are per second, so that the period may change."""

CHOICES = (
    "law",
    "feedforward",
    "has_anti_windup",
    "differentiates_reading",
    "follows_error",
    "is_scheduled",
)
"""Law, feedforward, and options that are on (1) or off (0): the integral stops where the current is at a limit; the
derivative is of the reading, not of the error; the direction of a line is the error's, not the set point's; gains
follow the slope of the model's branches."""

_SOURCES = PARAMETERS.names[-1] if PARAMETERS.names else ""

SETTINGS = np.dtype(
    [(name, "f8") for name in CHOICES]
    + [(parameter.name, "f8") for parameter in SETTING_PARAMETERS]
    + [("rising_currents", "f8", (TABLE_LENGTH,)), ("falling_currents", "f8", (TABLE_LENGTH,)), (_SOURCES, "f8")]
)
"""Type of the record that a law reads; its last name says which compiled sources it belongs to."""

RECOLLECTION = np.dtype(
    [
        (name, "f8")
        for name in (
            "is_started", "integral", "last_error", "last_reading", "last_setpoint", "last_output", "last_current",
            "direction", "line_offset", "clock", "knocked_from", "knock_direction",
            "phase", "held_current", "readings_sum", "readings_count",
            "rising_offset", "falling_offset", "began_at", "aimed_at", "stretch",
        )
    ]
)  # fmt: skip
"""Type of what a law remembers from period to period: readings and its own outputs, nothing of the valve."""
