"""How strongly an effect shows in a record, and the magnitude at which it shows as wanted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.blindtest.chain.clock import Signal
from diagnosis.blindtest.chain.sensor import digitised
from diagnosis.blindtest.formulations import Formulation
from diagnosis.blindtest.profiles import draw_profile
from diagnosis.blindtest.truth import Truth
from diagnosis.blindtest.valve import integrate

COARSE_STEP = 1e-4  # s; enough to size an effect
REFITTED = ("spring_rate", "coulomb_friction", "viscous_friction", "gap_offset", "gap_gain")
PROBE = 0.01  # relative change of a base parameter for its sensitivity
SEARCHES = 10
POWERS = (0.5, 4.0)  # of the magnitude, with which an effect may grow
TOLERANCE = 0.15  # relative miss of the wanted visibility that is good enough


@dataclass(frozen=True)
class Scale:
    """A base valve's trace under a test profile, and how it moves with the base parameters.

    Attributes
    ----------
    directions : array, shape (n, 5)
        Orthonormal basis of the changes that a small change of base parameters makes.
    """

    base: Mapping[str, float]
    time: Signal
    current: Signal
    trace: Signal
    directions: Signal

    def trace_with(self, effects: tuple[Truth, ...]) -> Signal:
        """The reading of the base valve with effects, without noise. [m]"""
        return _trace(self.base, self.time, self.current, effects)

    def visibilities(self, truth: Truth, base: Mapping[str, float] | None = None) -> tuple[float, float]:
        """Rms change of the reading by an effect, whole and beyond a refit to first order. [m]"""
        change = _trace(base or self.base, self.time, self.current, (truth,)) - self.trace
        left = change - self.directions @ (self.directions.T @ change)
        return float(np.sqrt(np.mean(change**2))), float(np.sqrt(np.mean(left**2)))


def _trace(base: Mapping[str, float], time: Signal, current: Signal, effects: tuple[Truth, ...]) -> Signal:
    """Noise-free reading, digitised where an effect does that. [m]"""
    sampled = integrate(base, time, current, step=COARSE_STEP, effects=effects)["position"]
    return digitised(sampled, np.zeros_like(sampled), 0.0, effects)


def scale_of(base: Mapping[str, float], seed: int) -> Scale:
    """Simulate a base valve and its sensitivities under a test profile."""
    time, current = draw_profile(seed)
    trace = _trace(base, time, current, ())
    columns = [_trace({**base, name: base[name] * (1 + PROBE)}, time, current, ()) - trace for name in REFITTED]
    directions, _ = np.linalg.qr(np.stack(columns, axis=1))
    return Scale(base, time, current, trace, directions)


def sized(truth: Truth, formulation: Formulation, scale: Scale, *, noise: float, target: float, floor: float) -> Truth:
    """The effect with the magnitude at which it shows as wanted, or at its nearest bound.

    Parameters
    ----------
    noise : float
        Rms noise of the reading. [m]
    target : float
        Wanted rms change over the noise: what a refit leaves of it, or all of it for a nuisance.
    floor : float
        Smallest magnitude over the formulation's lowest. [1]
    """
    name = formulation.magnitude
    if name is None:
        return truth
    low, high = formulation.lowest * floor, formulation.highest
    value, best, closest = float(np.sqrt(low * high)), truth, np.inf
    power, before = 1.0, None
    for _ in range(SEARCHES):
        trial = judged(truth.scaled(name, value), scale, noise)
        shown = max(trial.visibility if truth.nuisance else trial.unabsorbed, 1e-6)
        if not np.isfinite(shown):
            # The valve runs away, as where its diaphragm grows faster than its spring holds.
            high, value, before = value, float(np.sqrt(low * value)), None
            continue
        miss = float(np.log(shown / target))
        if abs(miss) < closest:
            best, closest = trial, abs(miss)
        low, high = (low, value) if miss > 0 else (value, high)
        if closest < TOLERANCE or high < low * (1 + TOLERANCE / 4):
            break
        if before is not None:
            power = float(np.clip((miss - before[1]) / np.log(value / before[0]), *POWERS))
        before = (value, miss)
        guess = value * float(np.exp(-miss / power))
        value = guess if low < guess < high else float(np.sqrt(low * high))
    return best


def judged(truth: Truth, scale: Scale, noise: float, base: Mapping[str, float] | None = None) -> Truth:
    """The effect with its visibilities over the noise, in a valve of other base parameters if given."""
    whole, left = scale.visibilities(truth, base)
    return replace(truth, visibility=whole / noise, unabsorbed=left / noise)
