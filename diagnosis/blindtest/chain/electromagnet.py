"""From the current to the gap between nozzle and flapper."""

from collections.abc import Mapping

import numpy as np
from numba import njit

from diagnosis.blindtest.chain.clock import Clock, Signal
from diagnosis.blindtest.truth import Truth, by_effect


@njit(cache=True)
def _bouc_wen(current, scale, shape):
    """Bouc-Wen memory in -1..1 that follows the current over `scale` amperes."""
    memory = np.zeros(current.size)
    parts = 20
    for k in range(1, current.size):
        value = memory[k - 1]
        change = (current[k] - current[k - 1]) / (scale * parts)
        for _ in range(parts):
            value += change * (1.0 - abs(value) ** shape * (0.6 * np.sign(change) * np.sign(value) + 0.4))
        memory[k] = value
    return memory


@njit(cache=True)
def _coleman_hodgdon(current, reach, slope):
    """Coleman-Hodgdon: dB/di = sign(di) (slope i - B)/reach + f, so B lags slope i by slope reach."""
    flux = np.zeros(current.size)
    flux[0] = slope * current[0]
    for k in range(1, current.size):
        change = current[k] - current[k - 1]
        if change == 0.0:
            flux[k] = flux[k - 1]
            continue
        direction = np.sign(change)
        # Exact along a monotone branch: B = slope (i - direction reach) + c exp(-|di|/reach).
        offset = flux[k - 1] - slope * (current[k - 1] - direction * reach)
        flux[k] = slope * (current[k] - direction * reach) + offset * np.exp(-abs(change) / reach)
    return flux


@njit(cache=True)
def _plays(current, radii, weights):
    """Weighted sum of play operators (a Preisach plane without congruent relays)."""
    total = np.zeros(current.size)
    state = np.full(radii.size, current[0])
    for k in range(current.size):
        value = 0.0
        for r in range(radii.size):
            state[r] = min(max(state[r], current[k] - radii[r]), current[k] + radii[r])
            value += weights[r] * state[r]
        total[k] = value
    return total


def _hysteresis(current: Signal, truth: Truth) -> Signal:
    """Effective current behind a rate-independent loop of half-width `loop_half_width`. [A]"""
    numbers = truth.parameters
    half_width = numbers["loop_half_width"]
    match truth.formulation:
        case "bouc_wen":
            return current - half_width * _bouc_wen(current, numbers["loop_reach"], numbers["loop_shape"])
        case "coleman_hodgdon":
            reach = numbers["loop_reach"]
            lag = _coleman_hodgdon(current, reach, 1.0)
            return current + (half_width / reach) * (lag - current)
        case "plays":
            radii = half_width * np.linspace(0.1, 3.0, 30)
            weights = np.exp(-radii / half_width)
            weights /= weights.sum()
            return _plays(current, radii * half_width / float(weights @ radii), weights)
    raise ValueError(f"magnetic_hysteresis has no formulation {truth.formulation!r}")


def _saturation(current: Signal, truth: Truth) -> Signal:
    """Effective current that falls behind above the knee. [A]"""
    knee, room = truth.parameters["knee_current"], 1.0 / truth.parameters["knee_curvature"]
    excess = np.maximum(current - knee, 0.0)
    match truth.formulation:
        case "froehlich":
            return np.minimum(current, knee) + excess / (1.0 + excess / room)
        case "tanh":
            return np.minimum(current, knee) + room * np.tanh(excess / room)
    raise ValueError(f"magnetic_saturation has no formulation {truth.formulation!r}")


@njit(cache=True)
def _lag(signal, substeps, step, time_constant, start):
    """First-order lag of a signal, exact for a value held through each fine step."""
    out = np.empty((signal.shape[0], substeps))
    keep = np.exp(-step / time_constant)
    wide = signal.shape[1] > 1
    state = start
    for k in range(signal.shape[0]):
        for j in range(substeps):
            out[k, j] = state
            target = signal[k, j] if wide else signal[k, 0]
            state = target + (state - target) * keep
    return out


def lagged(signal: Signal, clock: Clock, time_constant: float) -> Signal:
    """First-order lag that starts at rest; the value at the start of each fine step."""
    return _lag(signal, clock.substeps, clock.step, time_constant, float(signal[0, 0]))


def _coil_lag(current: Signal, clock: Clock, truth: Truth) -> Signal:
    """Current that acts, behind inductance and eddy currents. [A]"""
    time_constant = truth.parameters["time_constant"]
    slow = lagged(current, clock, time_constant)
    match truth.formulation:
        case "inductance":
            return slow
        case "inductance_and_eddy_currents":
            return lagged(slow, clock, time_constant * truth.parameters["eddy_share"])
    raise ValueError(f"coil_lag has no formulation {truth.formulation!r}")


def _gap_creep(time: Signal, truth: Truth) -> Signal:
    """Change of the gap with time, zero at the start. [m]"""
    numbers = truth.parameters
    shape = creep_shape(time, truth.formulation, numbers.get("time_constant", 0.0))
    return numbers["direction"] * numbers["gap_change"] * shape


def creep_shape(time: Signal, formulation: str, time_constant: float) -> Signal:
    """Zero at the start; one after 150 s (linear, logarithmic) or in the end (exponential)."""
    match formulation:
        case "linear":
            return time / 150.0
        case "exponential":
            return 1.0 - np.exp(-time / time_constant)
        case "logarithmic":
            return np.log1p(time / time_constant) / np.log1p(150.0 / time_constant)
    raise ValueError(f"a creep has no formulation {formulation!r}")


def gap(current: Signal, clock: Clock, base: Mapping[str, float], truths: tuple[Truth, ...]) -> Signal:
    """Gap between nozzle and flapper, never negative, shape (periods, width). [m]

    Parameters
    ----------
    current : array, shape (periods,)
        Held through each period. [A]
    """
    effects = by_effect(truths, "electromagnet")
    acting = current
    if "magnetic_hysteresis" in effects:
        acting = _hysteresis(acting, effects["magnetic_hysteresis"])
    if "magnetic_saturation" in effects:
        acting = _saturation(acting, effects["magnetic_saturation"])
    signal = clock.held(acting)
    if "coil_lag" in effects:
        signal = _coil_lag(signal, clock, effects["coil_lag"])
    opening = base["gap_offset"] - base["gap_gain"] * np.sqrt(np.maximum(signal, 0.0))
    if "gap_drift" in effects:
        opening += _gap_creep(clock.starts(), effects["gap_drift"])[:, None]
    return np.maximum(opening, 0.0)
