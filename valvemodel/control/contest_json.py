"""What control.json holds of a contest, with units."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from valvemodel.control.contest import Contest, Entry
from valvemodel.control.laws.settings import CHOICES, SETTING_PARAMETERS
from valvemodel.control.measures import BAND_SHARE, UNITS
from valvemodel.control.scenario import Scenario
from valvemodel.control.tuning import AGEING, WEAR, Bench

SCHEMA = "valvemodel.control/1"


def contest_json(contest: Contest) -> dict[str, Any]:
    """Return the content of control.json."""
    return {
        "schema": SCHEMA,
        "model": contest.bench.model.as_json(),
        "scenario": scenario_json(contest.scenario),
        "training": scenario_json(contest.training),
        "tuning": {
            "cost": "mean absolute error + 1 s x mean speed of travel beyond what the set points ask for",
            "wear": {"value": WEAR, "unit": "s"},
            "valves": f"as it is, and with friction grown by {100 * AGEING:g} %; the mean of both counts",
            "settings_tried": contest.budget,
            "method": "differential evolution, then Nelder-Mead, over the logarithms of the settings",
        },
        "settling_band": {"value": BAND_SHARE * contest.bench.model.values["rated_travel"], "unit": "m"},
        "calibration": calibration_json(contest.bench),
        "units": UNITS,
        "controllers": [_entry_json(entry) for entry in contest.entries],
    }


def scenario_json(scenario: Scenario) -> dict[str, Any]:
    """Return set points and conditions with their units."""
    levels = [float(scenario.setpoint[part.start]) for part in scenario.steps]
    return {
        "setpoints": {"value": levels, "unit": "m"},
        "duration": {"value": scenario.period * len(scenario.setpoint), "unit": "s"},
        "period": {"value": scenario.period, "unit": "s"},
        "noise": {"value": float(np.std(scenario.noise)), "unit": "m"},
        "resolution": {"value": scenario.resolution, "unit": "m"},
        "load": {"value": float(np.max(np.abs(scenario.load))), "unit": "N"},
    }


def calibration_json(bench: Bench) -> dict[str, Any]:
    """Return what self-calibration found, beside the true widths of the loop."""
    found = bench.calibration
    low, high = bench.branches.reach
    places = {"low": low, "middle": 0.5 * (low + high), "high": high}
    return {
        "records": {
            "current": {"value": [*found.rising[:, 0], *found.falling[:, 0]], "unit": "A"},
            "position": {"value": [*found.rising[:, 1], *found.falling[:, 1]], "unit": "m"},
        },
        "slope": {"value": found.slope, "unit": "m/A"},
        "rising_intercept": {"value": found.rising_intercept, "unit": "m"},
        "falling_intercept": {"value": found.falling_intercept, "unit": "m"},
        "threshold": {"value": found.threshold, "unit": "A"},
        "true_width": [
            {
                "where": name,
                "position": {"value": place, "unit": "m"},
                "value": (width := float(bench.branches.width(place))),
                "unit": "A",
                "error_of_threshold": found.threshold / width - 1.0,
            }
            for name, place in places.items()
        ],
    }


_UNITS_OF_SETTINGS = {name: "1" for name in CHOICES} | {each.name: each.unit for each in SETTING_PARAMETERS}


def _entry_json(entry: Entry) -> dict[str, Any]:
    return {
        "key": entry.kind.key,
        "title": entry.kind.title,
        "source": entry.kind.source,
        "knows": entry.kind.knows,
        "tuned": [tunable.name for tunable in entry.kind.tunables],
        "tuned_as": entry.kind.tuned_as or entry.kind.key,
        "settings": {
            name: {"value": value, "unit": _UNITS_OF_SETTINGS[name]}
            for name, value in entry.controller.settings.items()
        },
        "training_cost": {"value": entry.training_cost, "unit": "m"},
        "cost": {"value": entry.cost, "unit": "m"},
        "steps": [asdict(step) for step in entry.steps],
        "overall": entry.overall,
    }
