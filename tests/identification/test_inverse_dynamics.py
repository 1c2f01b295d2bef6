"""Inverse dynamics finds what an independent plant was given, and the published numbers of EMPS."""

from __future__ import annotations

import math
import os
from functools import cache
from pathlib import Path

import numpy as np
import polars
import pytest

from identification.fitting import fit_records
from identification.inverse_dynamics import (
    Preprocessing,
    diagnose_stem,
    fit_stem,
    prepare_signals,
    stem_candidates,
)
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.records.record import Record
from valvemodel.valves import read_valve

MASS, VISCOUS, COULOMB, PRELOAD = 20.0, 150.0, 25.0, 4.0
TRUTH = {
    "stem_mass": MASS,
    "viscous_friction": VISCOUS,
    "coulomb_friction": COULOMB,
    "spring_preload": PRELOAD,
}
RATE, SUBSTEPS, DURATION = 1000, 10, 25.0
POSITION_NOISE, FORCE_NOISE = 1e-7, 0.3

EFFECTS = {
    "asymmetric_viscous_friction": {"viscous_asymmetry": 0.3},
    "position_dependent_friction": {
        "tight_spot_excess": 0.8,
        "tight_spot_position": 0.17,
        "tight_spot_width": 0.03,
    },
    "stribeck": {"stribeck_ratio": 1.6, "stribeck_velocity": 0.02},
    "friction_drift": {"friction_drift_rate": 0.012},
    "spring_hardening": {"spring_rate": 2000.0, "spring_hardening": 9.0},
    "load_force": {"load_sine": 6.0, "load_cosine": -4.0, "load_period": 7.3},
    "presliding": {"presliding_compliance": 1.8e-5},
}
TOLERANCE = {"stribeck_velocity": 0.15, "presliding_compliance": 0.1, "stribeck_ratio": 0.06}


@cache
def plant(seed: int = 1, ripple: float = 0.0, **truth: float) -> Record:
    """A mass with friction under a sampled position controller, by explicit steps of 0.1 ms that share no
    code."""
    p = {
        "viscous_asymmetry": 0.0,
        "tight_spot_excess": 0.0,
        "stribeck_ratio": 1.0,
        "friction_drift_rate": 0.0,
    }
    p |= {"tight_spot_position": 0.0, "tight_spot_width": 1.0, "stribeck_velocity": 1.0, "spring_rate": 0.0}
    p |= {"spring_hardening": 0.0, "load_sine": 0.0, "load_cosine": 0.0, "load_period": 1.0}
    p |= {"presliding_compliance": 0.0} | truth
    step = 1.0 / RATE / SUBSTEPS
    y, v, bristle, last = 0.15, 0.0, 0.0, 0.15
    forces, positions, held = [], [], 0.0
    for sample in range(int(DURATION * RATE)):
        t = sample / RATE
        way = 2.0 * math.pi * t
        reference = 0.15 + 0.1 * math.sin(way / 9.1) + 0.04 * math.sin(way / 2.3) + 0.01 * math.sin(way / 0.9)
        force = 3e4 * (reference - y) + 1.2e3 * ((reference - last) * RATE - v)
        last = reference
        forces.append(0.5 * (force + held) if sample else force)
        held = force
        positions.append(y)
        angle = 2.0 * math.pi * t / p["load_period"]
        load = p["load_sine"] * math.sin(angle) + p["load_cosine"] * math.cos(angle)
        load += ripple * math.sin(2.0 * math.pi * y / 0.012)
        for _ in range(SUBSTEPS):
            spring = p["spring_rate"] * y * (1.0 + p["spring_hardening"] * y * y)
            net = force + load - spring - PRELOAD
            distance = (y - p["tight_spot_position"]) / p["tight_spot_width"]
            friction = COULOMB * (1.0 + p["friction_drift_rate"] * t)
            friction += COULOMB * p["tight_spot_excess"] * math.exp(-distance * distance)
            friction += COULOMB * (p["stribeck_ratio"] - 1.0) * math.exp(-abs(v) / p["stribeck_velocity"])
            if p["presliding_compliance"]:
                side = math.copysign(1.0, v)
                bristle += v * step * (1.0 - side * bristle / friction) / p["presliding_compliance"]
                net -= bristle
                friction = 0.0
            side = math.copysign(1.0, v if v else net)
            drag = VISCOUS * (1.0 + p["viscous_asymmetry"] * side)
            if v == 0.0 and abs(net) <= friction:
                continue
            moved = v + step * (net - side * friction - drag * v) / MASS
            v = 0.0 if friction and moved * side < 0.0 else moved
            y += step * v
    noise = np.random.default_rng(seed)
    size = len(forces)
    return Record.from_arrays(
        "plant",
        time=np.arange(size) / RATE,
        force=np.array(forces) + FORCE_NOISE * noise.standard_normal(size),
        position=np.array(positions) + POSITION_NOISE * noise.standard_normal(size),
    )


@cache
def diagnosis_of(key: str):
    """The diagnosis of the plant with one effect, made once."""
    return diagnose_stem(plant(**EFFECTS[key]))


def test_base_parameters_are_recovered_within_their_own_deviations():
    fit = fit_stem(plant())
    for name, truth in TRUTH.items():
        value, _, deviation = fit.parameters[name]
        assert value == pytest.approx(truth, rel=0.005), name
        assert 0.0 < deviation < 0.01 * truth, name
    assert fit.parameters["viscous_friction"].unit == "N*s/m"
    assert fit.regressors == ("stem_mass", "viscous_friction", "coulomb_friction", "spring_preload")
    assert fit.residual.shape == fit.time.shape == fit.force.shape
    assert "spring_rate" not in fit.parameters


def test_intervals_are_as_wide_as_few_blocks_make_them():
    """A record of 25 s has 25 blocks: Student's t of 24 degrees of freedom is 2.064."""
    valve = read_valve("calibrated")
    outcome = fit_records([plant()], Model(valve.name, valve.values))
    for each in outcome.parameters:
        low, high = outcome.determined.intervals[each.name]
        assert (high - low) / (2.0 * each.std) == pytest.approx(2.064, abs=1e-3), each.name


def test_standard_deviations_hold_under_correlated_noise():
    time = np.arange(15000) / RATE
    way = 2.0 * np.pi * time
    position = 0.1 * np.sin(way / 3.1) + 0.02 * np.sin(way / 0.7)
    velocity = np.gradient(position, time)
    force = MASS * np.gradient(velocity, time) + VISCOUS * velocity + COULOMB * np.sign(velocity) + PRELOAD
    noise = np.random.default_rng(3)
    slow = np.exp(-np.arange(400) / 100.0)
    squares = []
    for _ in range(40):
        error = np.convolve(noise.standard_normal(time.size + 399), 0.2 * slow, mode="valid")
        fit = fit_stem(Record.from_arrays(time=time, force=force + error, position=position), has_spring=False)
        for name, truth in TRUTH.items():
            value, _, deviation = fit.parameters[name]
            squares.append(((value - truth) / deviation) ** 2)
    assert 0.6 < np.mean(squares) < 1.6


def test_the_force_of_a_resting_stem_does_not_count():
    time = np.arange(20000) / RATE
    sine = np.sin(2.0 * np.pi * time / 2.7)
    velocity = np.sign(sine) * np.maximum(np.abs(sine) - 0.4, 0.0) ** 2
    position = np.cumsum(velocity) / RATE
    friction = np.where(velocity == 0.0, COULOMB * np.sin(7.0 * time), COULOMB * np.sign(velocity))
    force = MASS * np.gradient(velocity, time) + VISCOUS * velocity + friction + PRELOAD
    noise = np.random.default_rng(5)
    signals = prepare_signals(
        Record.from_arrays(
            time=time,
            force=force + 0.1 * noise.standard_normal(time.size),
            position=position + 1e-6 * noise.standard_normal(time.size),
        )
    )
    fit = fit_stem(signals, has_spring=False)
    assert signals.rows_left_out > 0.2 * signals.rows
    for name, truth in TRUTH.items():
        assert fit.values[name] == pytest.approx(truth, rel=0.02), name


def test_a_perfect_base_is_called_none():
    diagnosis = diagnose_stem(plant())
    assert diagnosis.verdict == "none"
    assert diagnosis.stage == "stem"
    assert ("asymmetric_friction",) in diagnosis.cause().indistinguishable_from
    assert diagnosis.gap.noise_floor <= diagnosis.gap.refitted


@pytest.mark.parametrize("key", EFFECTS)
def test_each_effect_is_named_and_its_parameters_recovered(key):
    diagnosis = diagnosis_of(key)
    assert diagnosis.verdict == "effect"
    best = diagnosis.causes[0]
    assert best.effects == (key,)
    assert best.probability > 0.9
    assert best.gap_closed > 0.8
    low, high = best.gap_closed_interval
    assert low <= best.gap_closed <= high
    for name, truth in EFFECTS[key].items():
        assert best.fit.values[name] == pytest.approx(truth, rel=TOLERANCE.get(name, 0.04)), name
        assert best.fit.parameters[name].std > 0.0


def test_two_effects_are_named_together():
    truth = EFFECTS["asymmetric_viscous_friction"] | EFFECTS["position_dependent_friction"]
    best = diagnose_stem(plant(**truth)).causes[0]
    assert set(best.effects) == {"asymmetric_viscous_friction", "position_dependent_friction"}
    assert best.fit.values["viscous_asymmetry"] == pytest.approx(0.3, rel=0.05)
    assert set(best.fit.by_effect()) == set(best.effects)


def test_an_effect_that_is_no_candidate_is_unknown():
    diagnosis = diagnose_stem(plant(ripple=8.0))
    assert diagnosis.verdict == "unknown"
    assert diagnosis.unknown_probability > 0.9


def test_probabilities_sum_to_one():
    diagnosis = diagnosis_of("friction_drift")
    total = sum(cause.probability for cause in diagnosis.causes) + diagnosis.unknown_probability
    assert total == pytest.approx(1.0)


def test_a_spring_is_found_and_its_absence_too():
    signals = prepare_signals(plant(spring_rate=2000.0))
    fit = fit_stem(signals)
    assert fit.values["spring_rate"] == pytest.approx(2000.0, rel=0.01)
    assert "spring_rate" not in fit_stem(signals, has_spring=False).parameters


def test_asymmetric_coulomb_friction_is_the_offset_in_other_words():
    base, other = fit_stem(plant()), fit_stem(plant(), effects=("asymmetric_friction",))
    np.testing.assert_allclose(base.residual, other.residual, atol=1e-8)
    assert other.parameters["spring_preload"].value == 0.0
    assert other.parameters["spring_preload"].std is None
    assert other.values["friction_asymmetry"] * other.values["coulomb_friction"] == pytest.approx(
        base.values["spring_preload"]
    )


def test_held_out_rows_do_not_enter_a_fit():
    signals = prepare_signals(plant())
    train = np.arange(signals.rows) < signals.rows // 2
    fit = fit_stem(signals, train=train)
    assert fit.held_out_rms == pytest.approx(math.sqrt(np.mean(fit.residual[~train] ** 2)))
    assert fit.rms != fit.held_out_rms
    assert np.abs(fit.design[train].T @ fit.residual[train]).max() < 1e-5
    assert fit_stem(signals).held_out_rms is None


def test_every_candidate_is_in_the_library_and_at_its_stage():
    from valvemodel.stages.stem import EFFECTS as LIBRARY

    keys = {effect.key for effect in LIBRARY}
    assert set(stem_candidates()) <= keys
    assert "spring_hardening" not in stem_candidates(has_spring=False)


def strokes(*, time=None, force=None, position=None, **others):
    """A record of sine strokes; an argument replaces a signal."""
    grid = np.arange(6000) / RATE
    return Record.from_arrays(
        "strokes",
        time=grid if time is None else time,
        force=np.cos(grid) + np.sign(np.cos(grid)) if force is None else force,
        position=np.sin(3.0 * grid) if position is None else position,
        **others,
    )


GRID = np.arange(6000) / RATE


@pytest.mark.parametrize(
    ("record", "said"),
    [
        (Record.from_arrays(time=GRID, position=GRID), "lacks force"),
        (strokes(position_unit="%"), "rated_travel"),
        (strokes(force=np.where(GRID == 1.0, np.nan, 1.0)), "sample 1001"),
        (strokes(position=np.ones(6000)), "position varies"),
        (strokes(force=np.ones(6000)), "force varies"),
        (strokes(position=GRID), "0 samples falling"),
        (strokes(time=GRID[::-1]), "time increases"),
        (strokes(time=GRID + 2.0 * (GRID > 3.0)), "regular sampling"),
        (strokes(position=1e-3 * np.random.default_rng(0).standard_normal(6000)), "noise"),
        (Record.from_arrays(time=GRID[:50], force=GRID[:50], position=GRID[:50]), "at least 100"),
        (Record.from_arrays(time=GRID[:700], force=GRID[:700], position=GRID[:700]), "after decimation"),
    ],
)
def test_hopeless_data_end_with_what_is_missing(record, said):
    with pytest.raises(InputError, match=said):
        fit_stem(record)


def test_wrong_arguments_are_named():
    signals = prepare_signals(strokes())
    with pytest.raises(InputError, match="asymmetric_viscous_friction"):
        fit_stem(signals, effects=("asymmetric_viscous",))
    with pytest.raises(InputError, match="truth value"):
        fit_stem(signals, train=[True])
    with pytest.raises(InputError, match="has_spring=True"):
        fit_stem(signals, effects=("spring_hardening",), has_spring=False)
    with pytest.raises(InputError, match="half the sampling rate"):
        prepare_signals(strokes(), Preprocessing(cutoff_frequency=600.0))
    with pytest.raises(InputError, match="decimation factor"):
        Preprocessing(factor=0)


@pytest.fixture(scope="module")
def emps() -> Record:
    beside = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    file = Path(os.environ.get("VALVEMODEL_DATA", beside)) / "emps" / "emps.csv"
    if not file.exists():
        pytest.skip(f"no EMPS record: {file} does not exist; set VALVEMODEL_DATA")
    table = polars.read_csv(file)
    return Record.from_arrays(
        "EMPS",
        time=table["time [s]"].to_numpy(),
        force=table["force [N]"].to_numpy(),
        position=table["position [m]"].to_numpy(),
    )


def test_emps_symmetric_friction_is_the_published_one(emps):
    fit = fit_stem(emps)
    published = {
        "stem_mass": 95.1089,
        "viscous_friction": 203.5034,
        "coulomb_friction": 20.3935,
        "spring_preload": -3.1648,
    }
    for name, value in published.items():
        assert fit.values[name] == pytest.approx(value, rel=0.005), name
    assert fit.relative_error == pytest.approx(4.0834, abs=0.3)


def test_emps_direction_dependent_friction_is_the_published_one(emps):
    fit = fit_stem(emps, effects=("asymmetric_viscous_friction",))
    viscous, share = fit.values["viscous_friction"], fit.values["viscous_asymmetry"]
    assert fit.values["stem_mass"] == pytest.approx(95.0, rel=0.005)
    assert viscous * (1.0 + share) == pytest.approx(166.7061, rel=0.005)
    assert viscous * (1.0 - share) == pytest.approx(240.4236, rel=0.005)
    assert fit.values["coulomb_friction"] + fit.values["spring_preload"] == pytest.approx(20.1440, rel=0.005)
    assert fit.values["coulomb_friction"] - fit.values["spring_preload"] == pytest.approx(20.6277, rel=0.005)
    assert fit.relative_error == pytest.approx(3.1117, abs=0.3)


def test_emps_calls_for_direction_dependent_viscous_friction(emps):
    diagnosis = diagnose_stem(emps)
    best = diagnosis.causes[0]
    assert diagnosis.verdict == "effect"
    assert best.effects == ("asymmetric_viscous_friction",)
    assert best.probability > 0.9
    assert best.gap_after_second_half < 0.85 * diagnosis.cause().gap_after_second_half
    assert not diagnosis.has_spring
