"""Current profiles as plant tests use them, drawn from a seed."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MILLIAMPERE = 1e-3
LOWEST, HIGHEST = 4.0, 20.0  # mA, the range of the converter
RAMP_LOWEST, RAMP_HIGHEST = 5.0, 19.5  # mA
STEP_LOWEST, STEP_HIGHEST = 4.5, 19.8  # mA
STEP_SIZES = (0.5, 1.0, 2.0, 3.0, 4.0, 7.0)  # mA


def _triangles(generator: np.random.Generator, time: Array, low: float, high: float) -> Array:
    """Ramps up and down between two currents, 15 to 18 s each. [mA]"""
    ramp = generator.uniform(15.0, 18.0)
    phase = np.abs((time / ramp + 1.0) % 2.0 - 1.0)
    return low + (high - low) * phase


def _steps(generator: np.random.Generator, time: Array, start: float, low: float, high: float) -> Array:
    """Random steps with dwells of 0.8 to 3 s; the range's ends are pulled inwards. [mA]"""
    current = np.empty_like(time)
    level, until = start, -np.inf
    for index, instant in enumerate(time):
        if instant >= until:
            until = instant + generator.uniform(0.8, 3.0)
            size = generator.choice(STEP_SIZES)
            up_share = 0.2 + 0.6 * (high - level) / (high - low)
            level += size if generator.random() < up_share else -size
            level = min(max(level, low), high)
        current[index] = level
    return current


def _waves(generator: np.random.Generator, time: Array, middle: float, half: float) -> Array:
    """A slow sine with small quick reversals on top. [mA]"""
    slow, quick = generator.uniform(20.0, 34.0), generator.uniform(3.0, 4.5)
    phases = generator.uniform(0.0, 2 * np.pi, 2)
    weight = generator.uniform(0.15, 0.28)
    wave = (1 - weight) * np.sin(2 * np.pi * time / slow + phases[0])
    return middle + half * (wave + weight * np.sin(2 * np.pi * time / quick + phases[1]))


def _mixed(generator: np.random.Generator, time: Array) -> Array:
    """Triangles for three tenths, steps to two thirds, waves to the end. [mA]"""
    duration = time[-1]
    first, second = 0.3 * duration, generator.uniform(0.63, 0.66) * duration
    current = _triangles(generator, time, RAMP_LOWEST, RAMP_HIGHEST)
    middle = (time >= first) & (time < second)
    last = time >= second
    start = float(current[np.searchsorted(time, first)])
    current[middle] = _steps(generator, time[middle], start, STEP_LOWEST, STEP_HIGHEST)
    current[last] = _waves(generator, time[last] - second, 12.0, 8.0)
    return current


def _only_triangles(generator: np.random.Generator, time: Array) -> Array:
    return _triangles(generator, time, RAMP_LOWEST, RAMP_HIGHEST)


def _only_steps(generator: np.random.Generator, time: Array) -> Array:
    start = generator.uniform(STEP_LOWEST + 2, STEP_HIGHEST - 2)
    return _steps(generator, time, start, STEP_LOWEST, STEP_HIGHEST)


def _small_travel(generator: np.random.Generator, time: Array) -> Array:
    """Steps, then waves, within a band of 5 to 7 mA, as in a valve that throttles. [mA]"""
    half = generator.uniform(2.5, 3.5)
    middle = generator.uniform(LOWEST + half + 1, HIGHEST - half - 1)
    late = time >= 0.5 * time[-1]
    current = _steps(generator, time, middle, middle - half, middle + half)
    current[late] = _waves(generator, time[late], middle, half)
    return current


KINDS: dict[str, Callable[[np.random.Generator, Array], Array]] = {
    "mixed": _mixed,
    "triangles": _only_triangles,
    "steps": _only_steps,
    "small": _small_travel,
}


def draw_profile(seed: int, *, duration: float = 150.0, rate: float = 50.0, kind: str = "mixed") -> tuple[Array, Array]:
    """Draw a test's current, held through each sample period.

    Parameters
    ----------
    seed : int
        The same seed gives the same profile.
    duration, rate : float
        Length [s] and samples a second [Hz].
    kind : str
        `mixed`, `triangles`, `steps` or `small`.

    Returns
    -------
    time, current : arrays, shape (duration * rate + 1,)
        [s], [A]; the current has five decimals of a milliampere, as a record prints it.
    """
    if kind not in KINDS:
        raise ValueError(f"profile kind must be one of {', '.join(KINDS)}, not {kind!r}")
    generator = np.random.default_rng([seed, 1])
    time = np.arange(round(duration * rate) + 1) / rate
    current = np.clip(KINDS[kind](generator, time), LOWEST, HIGHEST)
    return time, np.round(current, 5) * MILLIAMPERE
