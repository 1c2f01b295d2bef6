"""Stage by stage: each half of the chain driven by its measured input, where the pressure was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.experiment import Experiment
from identification.fit import Fit, finished, measured, simulate_model
from identification.problem import Problem
from identification.search import descend
from identification.starting.pressures import seen_by_pressure, told_by_pressure
from identification.unknowns import OF_GAP
from valvemodel.effects import effect_of_key
from valvemodel.model import Model

WIDEST = 8
"""An error of the pressure is averaged over at most 2**8 + 1 neighbouring samples."""

PRESSURE_AT_NOISE, POSITION_AT_NOISE = 1.15, 1.4
"""Gap over the noise up to which a half is right; what is left of the pressure's noise moves the stem a little."""

CONSISTENT = 3.0
"""Standard errors within which a wider mean of the error agrees with the narrower ones."""


@dataclass(frozen=True, eq=False)
class StageGaps:
    """What each half of the chain misses of its measured output when its measured input drives it.

    Attributes
    ----------
    pressure : arrays, each of shape (n,) [Pa]
        Measured less simulated pressure, the measured current in: the front's error.
    front : arrays, each of shape (n,) [m]
        What that does to the position: driven by the measured pressure less driven by the simulated one.
    back : arrays, each of shape (n,) [m]
        Measured position less simulated, the measured pressure in. Front and back add up to the whole error.
    pressure_noise, position_noise : float [Pa], [m]
    driven : list of Experiment
        With the measured pressure as the drive, its noise taken out.
    behind : Fit
        Of stem and sensor to these.
    """

    pressure: list[np.ndarray]
    front: list[np.ndarray]
    back: list[np.ndarray]
    pressure_noise: float
    position_noise: float
    driven: list[Experiment]
    behind: Fit

    @property
    def cross_term(self) -> float:
        """Mean of twice the product of front and back: mean squares of both and this are that of the sum. [m^2]"""
        front, back = np.concatenate(self.front), np.concatenate(self.back)
        return float(2.0 * np.nanmean(front * back))

    @property
    def shares(self) -> tuple[float, float] | tuple[None, None]:
        """Share of front and of back in their mean squares together, noise taken out; None where both are at it."""
        is_front_right = rms(self.pressure) <= PRESSURE_AT_NOISE * self.pressure_noise
        if is_front_right and rms(self.back) <= POSITION_AT_NOISE * self.position_noise:
            return None, None
        front = rms(self.front) ** 2
        back = max(rms(self.back) ** 2 - self.position_noise**2, 0.0)
        return front / (front + back), back / (front + back)


def rms(parts: Sequence[np.ndarray]) -> float:
    """Return the root mean square of all that is known."""
    return float(np.sqrt(np.nanmean(np.concatenate(parts) ** 2)))


def stage_gaps(experiments: Sequence[Experiment], base: Fit) -> StageGaps:
    """Drive each half of the chain by its measured input and compare its output.

    Each half is fitted on its own measured input and output, from the base fitted to all: an effect in one half then
    cannot bend the other. What the front misses of the pressure drives the stem without its noise, else a stem with
    friction would follow the peaks.

    Parameters
    ----------
    experiments : sequence of Experiment
        All with a measured pressure.
    base : Fit
        Of the base to these experiments.
    """
    front = front_of(experiments, base)
    simulated = [simulated_pressure(front, experiment) for experiment in experiments]
    off = [experiment.pressure - made for experiment, made in zip(experiments, simulated, strict=True)]
    quiet = [without_noise(error, each.pressure_noise) for error, each in zip(off, experiments, strict=True)]
    driven = [
        driven_by(experiment, made + error)
        for experiment, made, error in zip(experiments, simulated, quiet, strict=True)
    ]
    back = back_of(driven, base)
    followed = [back.simulated_on(each).position[0] for each in driven]
    whole = [
        position_of(back, number, driven_by(experiment, made))
        for number, (experiment, made) in enumerate(zip(experiments, simulated, strict=True))
    ]
    return StageGaps(
        pressure=off,
        front=[one - other for one, other in zip(followed, whole, strict=True)],
        back=[experiment.position - run for experiment, run in zip(experiments, followed, strict=True)],
        pressure_noise=float(np.sqrt(np.mean([each.pressure_noise**2 for each in experiments]))),
        position_noise=float(np.sqrt(np.mean([each.noise**2 for each in experiments]))),
        driven=driven,
        behind=back,
    )


def front_of(experiments: Sequence[Experiment], base: Fit) -> Fit:
    """Fit electromagnet and nozzle to the measured pressure alone, from where the fit of the whole has them."""
    used = [np.isfinite(np.asarray(experiment.pressure)) for experiment in experiments]
    problem = Problem(base.model, experiments, base.unknowns, used)
    told = told_by_pressure(problem)
    if not told:
        return finished(replace(problem, unknowns=[]), replace(base.found, point=np.empty(0)))
    return finished(*seen_by_pressure(problem, base.found.point, told))


def back_of(driven: Sequence[Experiment], base: Fit) -> Fit:
    """Fit stem and sensor to the position, the pressure given, from where the fit of the whole has them."""
    kept = [number for number, each in enumerate(base.unknowns) if each.name not in OF_GAP]
    unknowns = [base.unknowns[number] for number in kept]
    problem = Problem(stem_alone(base.model), driven, unknowns, measured(driven))
    return finished(problem, descend(problem, base.found.point[kept], evaluations=15, precision=1e-5))


def stem_alone(model: Model) -> Model:
    """Return the model of stem and sensor, whose input is the pressure itself in place of the current."""
    effects = {key: values for key, values in model.effects.items() if not effect_of_key(key).acts_on_pressure}
    return Model(model.name, {**model.values, "pressure_at_zero_current": 0.0, "pressure_per_current": 1.0}, effects)


def driven_by(experiment: Experiment, pressure: np.ndarray) -> Experiment:
    """Return an experiment whose input is the pressure of each sample, held through the period before it."""
    return replace(experiment, current=np.maximum(experiment.held_from(pressure), 0.0), pressure=None, late=0.0)


def simulated_pressure(front: Fit, experiment: Experiment) -> np.ndarray:
    """Return the pressure that the front half makes of the measured current, shape (n,). [Pa]"""
    return simulate_model(front.model, experiment, start_position=experiment.first_reading).pressure[0]


def position_of(back: Fit, number: int, driven: Experiment) -> np.ndarray:
    """Return the reading that the back half makes of another pressure than the fitted one, shape (n,). [m]"""
    return simulate_model(back.model, driven, start_position=back.starts[number]).position[0]


def without_noise(error: np.ndarray, noise: float) -> np.ndarray:
    """Return an error as the widest mean about each sample that agrees with all narrower ones, shape (n,).

    References
    ----------
    O. V. Lepski, "On a problem of adaptive estimation in Gaussian white noise", 1991.
    """
    known = np.isfinite(error)
    places = np.arange(len(error))
    error = np.interp(places, places[known], error[known])
    sums = np.concatenate(([0.0], np.cumsum(error)))
    found, low, high = error, np.full(len(error), -np.inf), np.full(len(error), np.inf)
    is_open = np.ones(len(error), bool)
    for power in range(WIDEST + 1):
        reach = np.minimum(2**power // 2, np.minimum(places, places[::-1]))
        count = 2 * reach + 1
        mean = (sums[places + reach + 1] - sums[places - reach]) / count
        error_of_mean = CONSISTENT * noise / np.sqrt(count)
        is_open &= (mean - error_of_mean <= high) & (mean + error_of_mean >= low)
        low = np.where(is_open, np.maximum(low, mean - error_of_mean), low)
        high = np.where(is_open, np.minimum(high, mean + error_of_mean), high)
        found = np.where(is_open, mean, found)
    return found
