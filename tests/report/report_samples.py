"""Diagnoses made up by hand, with the pictures' data, one for each kind of answer."""

from __future__ import annotations

from typing import Any

import numpy as np

from diagnosis.report import Evidence, Rank, RecordEvidence, Step


def record(name: str = "stroke.csv", *, count: int = 7500, with_pressure: bool = False) -> RecordEvidence:
    """Make a record of slow triangles of current with a stepping stem."""
    random = np.random.default_rng(5)
    time = np.arange(count) * 0.02
    phase = (time / 50.0) % 1.0
    current = 4e-3 + 16e-3 * np.where(phase < 0.5, 2 * phase, 2 - 2 * phase)
    rising = np.where(phase < 0.5, 1, -1)
    smooth = 0.2 * (current - 4e-3) / 16e-3 - 0.006 * rising
    sawtooth = (smooth / 14e-3) % 1.0
    slip = np.clip(sawtooth / 0.15, 0.0, 1.0)
    stepped = 14e-3 * (np.floor(smooth / 14e-3) + slip - 0.5)
    measured = stepped + 1.5e-4 * random.standard_normal(count)
    mode = np.where(sawtooth < 0.15, rising, 0)
    pressure = 40e3 + 170e3 * (current - 4e-3) / 16e-3
    return RecordEvidence(
        name=name,
        time=time,
        current=current,
        measured=measured,
        as_given=smooth * 1.02,
        refitted=smooth,
        with_cause=stepped,
        held_out=(time // 25) % 3 == 1,
        mode=mode,
        measured_pressure=pressure + 200 * random.standard_normal(count) if with_pressure else None,
        refitted_pressure=pressure * 1.01 if with_pressure else None,
        with_cause_pressure=pressure if with_pressure else None,
    )


def cause(effects: list[str], probability: float, gap_after: float, closed: float | None, **more: Any) -> dict:
    """Make an entry of `causes`."""
    return {
        "effects": effects,
        "probability": probability,
        "parameters": {},
        "gap_after": gap_after,
        "gap_closed": closed,
        "gap_closed_interval": None if closed is None else [closed - 0.01, closed + 0.004],
        "indistinguishable_from": [],
    } | more


def regimes() -> list[dict]:
    """Make the entries of `regimes`."""
    return [
        {"name": "stuck", "where": "while the stem is stuck", "rms": 1.7e-3, "share": 0.71},
        {"name": "rising", "where": "while the stem rises", "rms": 0.9e-3, "share": 0.17},
        {
            "name": "after a reversal",
            "where": "in the first 2 s after a reversal",
            "rms": 1.1e-3,
            "share": 0.12,
        },
    ]


def gap(with_cause: float | None = 1.58e-4) -> dict:
    """Make the entry `gap`."""
    return {
        "unit": "m",
        "as_given": 2.31e-3,
        "refitted": 1.94e-3,
        "with_cause": with_cause,
        "noise_floor": 1.5e-4,
        "scored_on": "held-out blocks",
    }


def effect() -> tuple[dict, Evidence]:
    """One effect, with one alternative that the record cannot tell."""
    friction = {"static_friction_ratio": {"value": 1.4012, "unit": "1", "std": 0.0031}}
    stribeck = {
        "stribeck_ratio": {"value": 1.42, "unit": "1", "std": 0.02},
        "stribeck_velocity": {"value": 2.1e-3, "unit": "m/s", "std": None},
    }
    diagnosis = {
        "schema": "valvemodel.diagnosis/1",
        "verdict": "effect",
        "where": {
            "stage": "stem",
            "stage_probability": {"electromagnet": 0.004, "nozzle": 0.006, "stem": 0.98, "sensor": 0.01},
            "regimes": regimes(),
        },
        "causes": [
            cause(
                ["static_friction"], 0.88, 1.58e-4, 0.9955,
                parameters={"static_friction": friction}, indistinguishable_from=[["stribeck"]],
            ),
            cause(["stribeck"], 0.09, 1.66e-4, 0.991, parameters={"stribeck": stribeck}),
            cause(["presliding"], 0.008, 1.1e-3, 0.47),
            cause([], 0.002, 1.94e-3, 0.0),
        ],
        "unknown_probability": 0.02,
        "gap": gap(),
    }  # fmt: skip
    evidence = Evidence(
        records=(record(with_pressure=True),),
        steps=(
            Step("as given", 2.31e-3),
            Step("base refitted", 1.94e-3),
            Step("+ static friction", 1.58e-4),
            Step("noise floor", 1.5e-4),
        ),
        ranking=(
            Rank("static friction", ("static_friction",), 1.58e-4, 1.5e-4, 1.7e-4, 0.88),
            Rank("Stribeck friction", ("stribeck",), 1.66e-4, 1.55e-4, 1.8e-4, 0.09),
            Rank("presliding", ("presliding",), 1.1e-3, 0.9e-3, 1.3e-3, 0.008),
            Rank("asymmetric viscous friction", ("asymmetric_viscous_friction",), 1.8e-3, 1.6e-3, 2.0e-3, 1e-5),
            Rank("none", (), 1.94e-3, 1.8e-3, 2.1e-3, 0.002),
        ),
        noise_floor=1.5e-4,
        unit="m",
        seconds=6.3,
        valve_name="calibrated",
        warnings=("row 412: 3 samples are missing (3.20 s to 3.28 s); the gap is not filled",),
    )
    return diagnosis, evidence


def two_effects() -> tuple[dict, Evidence]:
    """Two effects in two stages, several records, a stage that is not certain."""
    both = ["static_friction", "sensor_lag"]
    diagnosis = {
        "schema": "valvemodel.diagnosis/1",
        "verdict": "effect",
        "where": {
            "stage": "stem",
            "stage_probability": {"electromagnet": 0.03, "nozzle": 0.02, "stem": 0.62, "sensor": 0.33},
            "regimes": regimes(),
        },
        "causes": [
            cause(
                both, 0.74, 1.7e-4, 0.98,
                parameters={
                    "static_friction": {"static_friction_ratio": {"value": 1.31, "unit": "1", "std": 0.02}},
                    "sensor_lag": {"sensor_time_constant": {"value": 0.412, "unit": "s", "std": 0.019}},
                },
                indistinguishable_from=[
                    ["static_friction", "coil_lag"],
                    ["static_friction", "transport_delay"],
                ],
            ),
            cause(["static_friction", "coil_lag"], 0.12, 1.75e-4, 0.97),
            cause(["stribeck", "sensor_lag"], 0.11, 1.9e-4, 0.96),
            cause([], 0.0, 1.94e-3, 0.0),
        ],
        "unknown_probability": 0.03,
        "gap": gap(1.7e-4) | {"scored_on": "other records"},
    }  # fmt: skip
    evidence = Evidence(
        records=tuple(record(f"stroke-{letter}.csv", count=2500) for letter in "abcd"),
        steps=(
            Step("as given", 2.31e-3),
            Step("base refitted", 1.94e-3),
            Step("+ static friction", 8.1e-4),
            Step("+ sensor lag", 1.7e-4),
            Step("noise floor", 1.5e-4),
        ),
        ranking=(
            Rank("static friction and sensor lag", tuple(both), 1.7e-4, 1.6e-4, 1.9e-4, 0.74),
            Rank("static friction and coil lag", ("static_friction", "coil_lag"), 1.75e-4, 1.6e-4, 2e-4, 0.12),
            Rank("none", (), 1.94e-3, 1.8e-3, 2.1e-3, 0.0),
        ),
        noise_floor=1.5e-4,
        unit="m",
        seconds=8.1,
        valve_name="calibrated",
    )
    return diagnosis, evidence


def none() -> tuple[dict, Evidence]:
    """Nothing missing; linkage play could hide in the base model's friction."""
    diagnosis = {
        "schema": "valvemodel.diagnosis/1",
        "verdict": "none",
        "where": {
            "stage": None,
            "stage_probability": dict.fromkeys(("electromagnet", "nozzle"), 0.01),
            "regimes": [],
        },
        "causes": [
            cause([], 0.96, 1.51e-4, None, indistinguishable_from=[["linkage_backlash"]]),
            cause(["presliding"], 0.02, 1.5e-4, None),
        ],
        "unknown_probability": 0.02,
        "gap": gap(None) | {"refitted": 1.51e-4},
    }
    shown = record()
    evidence = Evidence(
        records=(
            RecordEvidence(**(vars(shown) | {"refitted": shown.with_cause, "with_cause": None, "as_given": None})),
        ),
        steps=(Step("as given", 2.31e-3), Step("base refitted", 1.51e-4), Step("noise floor", 1.5e-4)),
        ranking=(Rank("none", (), 1.51e-4, 1.4e-4, 1.6e-4, 0.96),),
        noise_floor=1.5e-4,
        unit="m",
        seconds=None,
        valve_name="table2",
    )
    return diagnosis, evidence


def unknown() -> tuple[dict, Evidence]:
    """A gap that nothing explains, with numbers that are not known."""
    diagnosis = {
        "schema": "valvemodel.diagnosis/1",
        "verdict": "unknown",
        "where": {
            "stage": "nozzle",
            "stage_probability": {"electromagnet": 0.2, "nozzle": 0.5, "stem": 0.2, "sensor": 0.1},
            "regimes": [{"name": "high", "where": "above 15 mA", "rms": None, "share": None}],
        },
        "causes": [
            cause(
                ["supply_droop"], 0.11, 1.1e-3, 0.44,
                parameters={"supply_droop": {"droop_gain": {"value": None, "unit": "1", "std": None}}},
            ),
            cause([], 0.02, 1.94e-3, None),
        ],
        "unknown_probability": 0.87,
        "gap": gap(1.1e-3) | {"noise_floor": None},
    }  # fmt: skip
    evidence = Evidence(
        records=(record(),),
        steps=(Step("as given", 2.31e-3), Step("base refitted", 1.94e-3), Step("+ supply droop", 1.1e-3)),
        ranking=(Rank("supply droop", ("supply_droop",), 1.1e-3, float("nan"), float("nan"), 0.11),),
        noise_floor=None,
        unit="m",
        seconds=7.0,
        valve_name="calibrated",
        warnings=("the pressure was not measured", "the current never falls below 6 mA"),
    )
    return diagnosis, evidence


def stem_record() -> tuple[dict, Evidence]:
    """A record of the stem alone, its gap in newtons, with a sample missing."""
    time = np.arange(5000) * 1e-3
    position = 0.15 * np.sin(2 * np.pi * time / 2.5)
    velocity = np.gradient(position, time)
    base = 20 * np.sign(velocity) + 200 * velocity
    found = base + 60 * np.maximum(velocity, 0)
    measured = found + 2 * np.random.default_rng(1).standard_normal(len(time))
    measured[1234] = np.nan
    shown = RecordEvidence(
        name="emps.csv",
        time=time,
        current=None,
        measured=measured,
        as_given=base * 1.1,
        refitted=base,
        with_cause=found,
        held_out=time > 2.5,
        mode=np.sign(velocity).astype(int),
        position=position,
    )
    diagnosis = {
        "schema": "valvemodel.diagnosis/1",
        "verdict": "effect",
        "where": {"stage": "stem", "stage_probability": {"stem": 1.0}, "regimes": []},
        "causes": [
            cause(
                ["asymmetric_viscous_friction"], 0.995, 2.02, 0.998,
                parameters={
                    "asymmetric_viscous_friction": {
                        "viscous_asymmetry": {"value": 0.13, "unit": "1", "std": 0.002}
                    }
                },
            ),
            cause([], 0.003, 9.4, 0.0),
        ],
        "unknown_probability": 0.002,
        "gap": {
            "unit": "N", "as_given": 18.2, "refitted": 9.4, "with_cause": 2.02, "noise_floor": 2.0,
            "scored_on": "held-out blocks",
        },
    }  # fmt: skip
    evidence = Evidence(
        records=(shown,),
        steps=(
            Step("as given", 18.2),
            Step("base refitted", 9.4),
            Step("+ effect", 2.02),
            Step("noise floor", 2.0),
        ),
        ranking=(Rank("asymmetric viscous friction", ("asymmetric_viscous_friction",), 2.02, 1.9, 2.1, 0.995),),
        noise_floor=2.0,
        unit="N",
        seconds=1.2,
        valve_name="emps",
    )
    return diagnosis, evidence


SAMPLES = {
    "effect": effect,
    "two effects": two_effects,
    "none": none,
    "unknown": unknown,
    "stem record": stem_record,
}
