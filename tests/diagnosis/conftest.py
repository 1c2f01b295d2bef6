"""A minute of a valve without an effect, with its pressure, and ways to judge it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.blindtest.plants import draw_plant, measure
from diagnosis.score import score_fit
from diagnosis.trying.candidates import Candidate
from identification.experiment import Experiment, experiment_of
from identification.fit import fit_base
from identification.holdout import Holdout, hold_out
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.valves import read_valve


@pytest.fixture(scope="session")
def minute() -> Record:
    """One minute of a plant without an effect, pressure measured."""
    taken = measure(draw_plant(3, ()), 7, duration=60.0, with_pressure=True)
    return Record.from_arrays(name="minute", **{name: taken[name] for name in taken})


@pytest.fixture(scope="session")
def given() -> Model:
    """The calibrated valve."""
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


@pytest.fixture(scope="session")
def quiet(minute: Record) -> Experiment:
    """The minute as an experiment of current and position."""
    return replace(experiment_of(minute), pressure=None)


@pytest.fixture(scope="session")
def refitted(given: Model):
    """Fit the base to a changed position of the minute and score it."""

    def refit(experiment: Experiment, extra: np.ndarray | float = 0.0) -> tuple[Candidate, Holdout]:
        holdout = hold_out([replace(experiment, position=experiment.position + extra)])
        fit = fit_base(given, holdout.experiments, holdout.fitted)
        return Candidate((), fit, score_fit(fit, holdout)), holdout

    return refit
