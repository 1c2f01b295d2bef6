"""The next experiment keeps its limits, tells rivals apart as an actual refit does, and says where it cannot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from diagnosis import next_experiment as designing
from diagnosis.next_experiment import SEGMENTS, Limits, first_designs, next_experiment, profile_of
from diagnosis.separation import blank_experiment, least_separation, rival_of, separations
from diagnosis.trying.candidates import Candidate, Work, try_effect
from identification.experiment import Experiment
from identification.fit import fit_base, fitted_to_all, measured, simulate_model
from valvemodel.model import Model

RATE = 2e-3


@dataclass
class Answer:
    """As much of a diagnosis as the design of the next experiment looks at."""

    effects: tuple[str, ...]
    rivals: list[tuple[str, ...]]
    tried: list[Candidate]
    experiments: list[Experiment]
    causes: list = field(default_factory=list)

    @property
    def cause(self):
        return self


@pytest.mark.parametrize("rate", [np.inf, RATE])
def test_profiles_keep_the_limits(rate: float):
    limits = Limits(6e-3, 15e-3, rate, 80.0)
    for design in first_designs(np.random.default_rng(1)):
        assert design.shape == (3 * SEGMENTS + 1,)
        time, current = profile_of(design, limits, 0.05)
        assert time[-1] == pytest.approx(80.0)
        assert current.min() >= 6e-3
        assert current.max() <= 15e-3
        assert np.abs(np.diff(current)).max() <= rate * 0.05 + 1e-8


@pytest.fixture(scope="module")
def creeping(quiet, refitted) -> Answer:
    """A lag and a delay, both fitted to a record that a lag is in, without its fast part."""
    slow = quiet.time < 18.0
    part = {name: getattr(quiet, name)[slow] for name in ("time", "current", "position", "block")}
    short = Experiment("ramp", pressure=None, noise=quiet.noise, pressure_noise=0.0, **part)
    lagged = np.interp(short.time - 0.08, short.time, short.position) - short.position
    base, holdout = refitted(short, lagged)
    lag, delay = {"sensor_time_constant": 0.08, "sensor_second_time_constant": 0.0}, {"transport_delay": 0.08}
    known = {("sensor_lag",): lag, ("transport_delay",): delay | {"line_dispersion": 0.0}}
    keys = list(known)
    # So little shows of either that a search from afar may leave it at none.
    work = [Work(base.fit, effects, is_global=False, known=values, is_known=True) for effects, values in known.items()]
    tried = [base, *(try_effect(each, holdout) for each in work)]
    return Answer(keys[0], keys[1:], tried, list(holdout.experiments))


def test_designed_steps_tell_a_lag_from_a_delay(creeping: Answer):
    designed = next_experiment(creeping, Limits(duration=15.0))
    assert designed.rivals == [("sensor_lag",), ("transport_delay",)]
    assert designed.is_open
    # A transmitter that lags twice follows a delay in most profiles, whatever a refit to first order says.
    assert designed.separation["profile"] > 10.0 * designed.separation["now"]
    assert designed.separation["profile_and_pressure"] > 0.85 * designed.separation["profile"]
    same = next_experiment(creeping, Limits(duration=15.0))
    assert np.array_equal(same.current, designed.current)


def test_separation_that_is_told_is_what_a_refit_leaves(creeping: Answer):
    one, other = creeping.tried[1:]
    time, current = profile_of(first_designs(np.random.default_rng(0))[0], Limits(duration=20.0), 0.02)
    blank = blank_experiment(time, current, noise=creeping.experiments[0].noise)
    rivals = [rival_of(each.effects, each.fit) for each in (one, other)]
    told, pair = least_separation(rivals, creeping.experiments, blank)
    assert pair in ((one.effects, other.effects), (other.effects, one.effects))
    first, second = (one, other) if pair[0] == one.effects else (other, one)
    truth = simulate_model(first.fit.model, blank, start_position=np.nan).position[0]
    taken = Experiment("next", time, current, truth, None, blank.noise, 0.0, blank.block)
    both = fitted_to_all(second.fit, [*creeping.experiments, taken])
    left = (truth - both.simulated_on(taken).position[0]) / blank.noise
    assert told == pytest.approx(float(np.sqrt(np.mean(left**2))))
    assert told > 1.0


def test_two_of_the_same_model_cannot_be_told_apart(quiet, given: Model):
    fit = fit_base(given, [quiet], measured([quiet]))
    twins = [rival_of((), fit), rival_of((), fit)]
    time, current = profile_of(first_designs(np.random.default_rng(0))[1], Limits(duration=20.0), 0.02)
    assert separations(twins, blank_experiment(time, current, noise=quiet.noise)) == {(0, 1): 0.0, (1, 0): 0.0}


@pytest.mark.parametrize(
    ("promised", "left", "chosen", "refitted"),
    [
        ((90.0, 80.0, 70.0, 2.0), (4.0, 9.0, 75.0, 90.0), 2, 3),  # the last one promises less than is left
        ((90.0, 80.0, 70.0, 2.0), (1.5, 1.6, 1.2, 1.9), 3, 4),
        ((0.6, 0.5, 0.4, 0.3), (0.1, 0.2, 0.3, 0.3), 0, 0),  # within the noise
    ],
)
def test_the_best_profile_by_refits_is_chosen(monkeypatch, promised, left, chosen, refitted):
    asked = []
    profiles = [(np.array([0.0, 1.0]), np.full(2, 1e-3 * number)) for number in range(4)]
    of_current = {1e-3 * number: value for number, value in enumerate(left)}
    monkeypatch.setattr(
        designing, "left_by_refits", lambda *given: (asked.append(given) or of_current[given[-1][0]], None)
    )
    best = designing.best_by_refits([], [], profiles, np.array(promised))
    assert best is profiles[chosen]
    assert len(asked) == refitted
