"""A record from a valve in service runs through: percent of span at 1 Hz, closed loop, little travel."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.diagnosing import diagnose
from diagnosis.trials.marking import CONFIDENT
from diagnosis.trying.unrecorded import with_unrecorded
from identification.driving.between_rows import FAR_APART, UNSEEN
from identification.experiment import experiment_of
from identification.fit import fit_base
from valvemodel.commands import command_line
from valvemodel.control.controller import Controller
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

RATED_TRAVEL = 0.25
SPRING_RATE, AREA, COULOMB = 60e3, 0.0645, 1100.0
NOISE, COARSE_NOISE = 0.1e-3, 0.25e-3


def played(position: float, current: float) -> float:
    """Rest a stem without mass on spring and dry friction: the play operator, which shares no code with the toolkit."""
    force = AREA * (38e3 + 11.2e6 * (current - 4e-3))
    return min(max(position, (force - COULOMB) / SPRING_RATE), (force + COULOMB) / SPRING_RATE)


def logged(*, period: float, noise: float, integral_gain: float = 0.003, seconds: int = 400) -> np.ndarray:
    """Return time, current and reading, once a second, of a loop whose set point moves by some 2 % every 50 s."""
    generator = np.random.default_rng(4)
    gains = {"proportional_gain": 0.02, "integral_gain": integral_gain, "start_current": 11e-3, "period": period}
    controller = Controller("PI", gains).started()
    position, rows, every = 0.125, [], round(1.0 / period)
    for tick in range(seconds * every):
        if tick % (50 * every) == 0:
            setpoint = RATED_TRAVEL * (0.5 + 0.02 * generator.standard_normal())
        reading = position + noise * generator.standard_normal()
        current = controller(setpoint, reading)
        if tick % every == 0:
            rows.append((tick * period, current, reading))
        position = played(position, current)
    return np.array(rows)


def test_diagnosis_of_a_record_in_service(tmp_path: Path) -> None:
    time, current, reading = logged(period=0.1, noise=COARSE_NOISE).T
    table = np.column_stack([time, 100.0 * (current - 4e-3) / 16e-3, 100.0 * reading / RATED_TRAVEL])
    path, out = tmp_path / "service.csv", tmp_path / "out"
    header = "time [s],current [%],position [%]"
    np.savetxt(path, table, fmt="%.3f", delimiter=",", header=header, comments="")
    result = CliRunner().invoke(command_line, ["diagnose", str(path), "--out", str(out), "--jobs", "2"])
    assert result.exit_code == 0, result.output
    content = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    best = content["causes"][0]
    assert not best["effects"] or best["probability"] < CONFIDENT
    assert content["gap"]["refitted"] < content["gap"]["as_given"]


@pytest.mark.parametrize(("integral_gain", "is_noted"), [(0.01, True), (0.001, False)])
def test_noise_has_in_it_what_happened_between_the_rows(given, integral_gain: float, is_noted: bool) -> None:
    time, current, reading = logged(period=0.1, noise=NOISE, integral_gain=integral_gain).T
    experiment = experiment_of(Record.from_arrays(name="service", time=time, current=current, position=reading))
    base = fit_base(given, [experiment])
    (blurred,), notes = with_unrecorded([experiment], base)
    missed = np.sqrt(np.mean((experiment.position - base.simulated_on(experiment).position[0]) ** 2))
    assert bool(notes) == is_noted
    assert missed < 1.3 * blurred.noise
    assert (blurred.noise > 1.3 * experiment.noise) == is_noted


def test_fast_rows_have_no_sampling_error(given, quiet) -> None:
    (same,), notes = with_unrecorded([quiet], fit_base(given, [quiet]))
    assert same is quiet
    assert not notes


FRICTIONS = [each.key for each in EFFECTS if each.key.endswith("friction")]


@pytest.mark.parametrize(
    ("effect", "every"), [("position_dependent_friction", 5), ("", 5), ("choked_flow", 10), ("", 10)]
)
def test_a_logger_slower_than_the_driver_names_what_is_there(effect: str, every: int) -> None:
    keys = (effect,) if effect else ()
    taken = measure(draw_plant(5, keys), 1005, duration=90.0)
    slow = Record.from_arrays(name="slow", **{name: values[::every] for name, values in taken.items()})
    valve = read_valve("calibrated")
    # The search for a tight spot beside all others takes two minutes: it is told from friction of other kinds here.
    candidates = FRICTIONS if effect in FRICTIONS else None
    found = diagnose([slow], Model(valve.name, valve.values), candidates=candidates, jobs=2)
    assert any((UNSEEN if every == 5 else FAR_APART) in each for each in found.warnings)
    assert found.cause.effects == keys
    assert found.verdict == ("effect" if effect else "none")
    assert found.cause.errors.rms < 1.25 * found.floor
