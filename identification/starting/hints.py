"""Hints: where a search for an effect begins, read off the record and off what the fit so far leaves over."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import product

import numpy as np

from identification.experiment import Experiment, are_loops
from identification.noise import reading_grid
from valvemodel.declarations import Effect, Parameter

BIN = 0.125
"""Width of the bins in which readings are counted, over their noise."""

MOST_BINS = 200_000
"""Over the span of the readings: those of another simulation have no noise."""

COARSE, ON_THE_GRID = 8.0, 0.98
"""Step of a grid, over the noise, from which it is coarse; share of the readings that lie within three times the noise
of it if it is that of the reading: at that step three quarters of any readings do."""

ROUNDED_OFF = 0.7
"""Share of what a coarse grid rounds off, root mean square, that a fit of smooth readings leaves at least."""

PLACES = 9
"""Places along the travel at which a local effect is looked for."""

PERIODS = 4
"""Strongest periods of the residual at which a periodic effect is looked for."""

CLOSEST, CLOCK_ERROR = 0.1, 0.01
"""Time between rows up to which those of a faster record are passed over where periods are looked for [s]; share by
which a clock may be off."""

LOWEST_WAVES, HALF_WAVE, QUARTER_WAVE = 16.0, 0.5, 0.25
"""Waves in a record up to which all periods are tried, and their distance; and that about the strongest periods."""

SHRUNK = 0.1
"""Share of a start's size that is tried where the start itself leads away from the fit."""

Residuals = list[np.ndarray]


def starts_of(effect: Effect, experiments: list[Experiment], residuals: Residuals) -> Iterator[dict[str, float]]:
    """Yield the points at which a search for an effect begins, every parameter named.

    Parameters
    ----------
    effect : Effect
    experiments : list of Experiment
    residuals : list of arrays [m]
        Measured less simulated position, one for each experiment, NaN where nothing counts.
    """
    choices = {each.name: _choices(each, experiments, residuals) for each in effect.parameters}
    choices |= {each.name: [each.neutral] for each in effect.parameters if each.acts_in_time and are_loops(experiments)}
    endless = {each.name: [each.neutral] for each in effect.parameters if effect.is_one_of and math.isinf(each.neutral)}
    for acting in endless or [""]:
        idle = {name: neutral for name, neutral in endless.items() if name != acting}
        for combination in product(*(choices | idle).values()):
            start = dict(zip(choices, combination, strict=True))
            if not effect.laws or any(law.items() <= start.items() for law in effect.laws):
                yield start


def other_forms(effect: Effect, values: Mapping[str, float]) -> list[dict[str, float]]:
    """Return the values of an effect in each of its other forms: with other numbers that no fit moves.

    What is read off the record stays as it is, and what the form at hand alone holds goes to its first other start, if
    it has one.
    """
    chosen = {
        each.name: [values[each.name] if isinstance(start, str) else float(start) for start in each.starts]
        for each in effect.parameters
        if not each.is_fitted
    }
    forms = effect.laws or [dict(zip(chosen, each, strict=True)) for each in product(*chosen.values())]
    held = effect.held_at(values)
    loosened = {
        each.name: next((float(start) for start in each.starts if start != values[each.name]), values[each.name])
        for each in effect.fitted
        if each.name in held
    }
    made = ({**values, **loosened, **form} for form in forms)
    return [each for each in made if effect.form_at(each) != effect.form_at(values)]


def resized(effect: Effect, start: Mapping[str, float], share: float) -> dict[str, float]:
    """Return a start of an effect at so many times its size, within its bounds; the numbers that are no sizes stay."""
    return dict(start) | {
        each.name: min(max(each.neutral + share * (start[each.name] - each.neutral), each.low), each.high)
        for each in effect.free_at(start)
        if each.is_size and math.isfinite(start[each.name])
    }


def _choices(parameter: Parameter, experiments: list[Experiment], residuals: Residuals) -> list[float]:
    values: list[float] = []
    for start in parameter.starts:
        values += _hinted(start, experiments, residuals) if isinstance(start, str) else [float(start)]
    return [value if math.isinf(value) else min(max(value, parameter.low), parameter.high) for value in values]


def _hinted(hint: str, experiments: list[Experiment], residuals: Residuals) -> list[float]:
    readings = np.concatenate([each.position[np.isfinite(each.position)] for each in experiments])
    grids = (coarsest_grid(each, left_over(left)) for each, left in zip(experiments, residuals, strict=True))
    if hint == "highest_reading":
        return [float(np.quantile(readings, 0.999))]
    if hint == "lowest_reading":
        return [float(np.quantile(readings, 0.001))]
    if hint == "reading_step":
        return [max(grids)[0]]
    if hint == "reading_phase":
        return [max(grids)[1]]
    if hint == "travel_place":
        low, high = np.quantile(readings, [0.02, 0.98])
        return [float(place) for place in np.linspace(low, high, PLACES)]
    assert hint == "residual_period", hint
    longest = max(range(len(residuals)), key=lambda number: len(residuals[number]))
    return strongest_periods(experiments[longest].time, residuals[longest])


def strongest_periods(time: np.ndarray, residual: np.ndarray) -> list[float]:
    """Return the periods at which sine and cosine explain most of a residual, best first. [s]

    Frequencies from half a wave in the record up to the period of one second, and below half the rate of the rows that
    are looked at, in steps of a quarter wave.
    """
    kept = np.isfinite(residual)
    interval = float(np.median(np.diff(time[kept])))
    every = max(int(CLOSEST / interval * (1.0 + CLOCK_ERROR)), 1)
    time, residual = time[kept][::every], residual[kept][::every]
    residual = residual - residual.mean()
    duration = time[-1] - time[0]
    most_waves = min(duration, 200.0, 0.5 * duration / (every * interval))
    frequencies = np.arange(0.5, most_waves, 0.25) / duration
    wave = np.exp(-2j * np.pi * frequencies[:, None] * time)
    power = np.abs(wave @ residual)
    periods: list[float] = []
    for index in np.argsort(power)[::-1]:
        period = 1.0 / frequencies[index]
        if all(abs(duration / period - duration / other) >= 1.0 for other in periods):
            periods.append(float(period))
        if len(periods) == PERIODS:
            break
    return periods


def is_periodic(parameter: Parameter) -> bool:
    """Return whether a parameter is a period that is read off what a fit leaves over."""
    return "residual_period" in parameter.starts


def begins_at_periods(effect: Effect) -> bool:
    """Return whether a search for an effect begins at periods that are read off what a fit leaves over."""
    return any(is_periodic(each) for each in effect.parameters)


def nearby(periods: list[float], duration: float) -> list[float]:
    """Return periods up to a wave beside some, and of the lowest waves of a record, the longest first. [s]"""
    beside = np.arange(-1.0, 1.0 + QUARTER_WAVE, QUARTER_WAVE)
    counts = [duration / period + beside for period in periods]
    lowest = np.arange(HALF_WAVE, LOWEST_WAVES, HALF_WAVE)
    every = np.unique(np.round(np.concatenate([lowest, *counts]) / QUARTER_WAVE))
    return [float(duration / (QUARTER_WAVE * count)) for count in every if count * QUARTER_WAVE >= HALF_WAVE]


@lru_cache(maxsize=8)
def coarse_step(experiment: Experiment) -> float:
    """Return the step of the coarse grid that readings lie on, 0 where they lie on none. [m]

    A rest of the reading says little of where the stem is on one.
    """
    step, offset = coarsest_grid(experiment)
    if step <= COARSE * experiment.noise:
        return 0.0
    places = (experiment.position[np.isfinite(experiment.position)] - offset) / step
    off = np.abs(places - np.round(places)) * step
    return step if np.mean(off < 3.0 * experiment.noise) >= ON_THE_GRID else 0.0


def left_over(residual: np.ndarray) -> float:
    """Return the root mean square of what a fit leaves where it counts; infinite where nothing does. [m]"""
    kept = residual[np.isfinite(residual)]
    return float(np.sqrt(np.mean(kept**2))) if len(kept) else math.inf


def coarsest_grid(experiment: Experiment, left: float = math.inf) -> tuple[float, float]:
    """Return step and offset of the coarsest grid that the readings crowd around, noise on top allowed. [m]

    A grid wider than the noise makes the readings add up in phase when they are wound around its step; the display
    grid of the values themselves is returned where none does better. Readings at a few levels, as long holds leave,
    crowd around many a grid: of one that rounds off more than a smooth fit has `left` over none can come. [m]
    """
    readings = experiment.position[np.isfinite(experiment.position)]
    shown = reading_grid(readings)
    if shown[0] > 3.0 * experiment.noise:
        return shown
    # Wave numbers up to one in five times the noise, in steps of a fifth of one over the span: readings in fine bins.
    span = max(float(np.ptp(readings)), 1e-9)
    bin_width = max(BIN * experiment.noise, span / MOST_BINS)
    counts = np.bincount(((readings - readings.min()) / bin_width).astype(int))
    length = max(round(5.0 * span / bin_width), len(counts))
    wave_numbers = np.arange(length // 2 + 1) / (length * bin_width)
    usable = (wave_numbers >= 4.0 / span) & (wave_numbers < 1.0 / (5.0 * experiment.noise))
    wave_numbers, strength = wave_numbers[usable], np.abs(np.fft.rfft(counts, length))[usable] / len(readings)
    if len(strength) == 0 or strength.max() < 0.5:
        return shown
    step = float(1.0 / wave_numbers[np.argmax(strength)])
    for _ in range(3):
        numbers = np.round(
            (readings - np.angle(np.exp(2j * np.pi * readings / step).mean()) * step / (2 * np.pi)) / step
        )
        step, offset = (float(each) for each in np.polyfit(numbers, readings, 1))
    if left < ROUNDED_OFF * step / math.sqrt(12.0):
        return shown
    return step, offset - step * round(offset / step)
