"""One small valve that every display test looks at, from its record to its diagnosis."""

import numpy as np
import pytest

from diagnosis import Diagnosis, diagnose
from identification import Outcome, fit_records
from valvemodel import Model, Record, Trajectory, read_valve, simulate


@pytest.fixture(autouse=True)
def _closed_figures():
    import matplotlib
    import matplotlib.pyplot as plt

    matplotlib.use("Agg")
    yield
    plt.close("all")


@pytest.fixture(scope="session")
def model() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


@pytest.fixture(scope="session")
def run(model: Model) -> Trajectory:
    time = np.arange(0.0, 40.0, 0.05)
    current = 12e-3 + 6e-3 * np.sin(0.4 * time) * np.cos(0.11 * time)
    return simulate(model, time=time, current=current)


@pytest.fixture(scope="session")
def record(run: Trajectory) -> Record:
    noise = 1e-4 * np.random.default_rng(1).normal(size=len(run))
    return Record.from_arrays("a < b", time=run.time, current=run.current, position=run.position + noise)


@pytest.fixture(scope="session")
def outcome(record: Record, model: Model) -> Outcome:
    return fit_records([record], model)


@pytest.fixture(scope="session")
def diagnosis(record: Record) -> Diagnosis:
    return diagnose(record, candidates=["spring_hardening", "sensor_drift"], jobs=1)
