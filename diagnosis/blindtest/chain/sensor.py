"""From the stem's travel to the reading."""

import numpy as np
from numba import njit

from diagnosis.blindtest.chain.clock import Clock, Signal
from diagnosis.blindtest.chain.electromagnet import creep_shape, lagged
from diagnosis.blindtest.truth import Truth, by_effect

SPAN = 0.22  # m of travel over which a linkage is set to read true at both ends


@njit(cache=True)
def _play(travel, half_width, start):
    """Follower with play, dragged by the stem."""
    out = np.empty_like(travel)
    state = start
    for k in range(travel.shape[0]):
        for j in range(travel.shape[1]):
            state = min(max(state, travel[k, j] - half_width), travel[k, j] + half_width)
            out[k, j] = state
    return out


@njit(cache=True)
def _elastic_play(travel, half_width, softness, start):
    """Play whose edges yield: two plays in series share the gap."""
    out = np.empty_like(travel)
    outer, inner = start, start
    for k in range(travel.shape[0]):
        for j in range(travel.shape[1]):
            outer = min(max(outer, travel[k, j] - half_width * 1.3), travel[k, j] + half_width * 1.3)
            inner = min(max(inner, travel[k, j] - half_width * 0.7), travel[k, j] + half_width * 0.7)
            out[k, j] = softness * outer + (1.0 - softness) * inner
    return out


def _backlash(travel: Signal, truth: Truth) -> Signal:
    """Travel that the transmitter's arm follows. [m]"""
    half_width = 0.5 * truth.parameters["play"]
    start = travel[0, 0] + half_width * truth.parameters["start"]
    match truth.formulation:
        case "play":
            return _play(travel, half_width, start)
        case "worn_play":
            return _elastic_play(travel, half_width, 0.5, start)
    raise ValueError(f"linkage_backlash has no formulation {truth.formulation!r}")


def _arm(travel: Signal, truth: Truth) -> Signal:
    """Reading of a rotary arm, true at zero and at the span's end. [m]"""
    numbers = truth.parameters
    if truth.formulation == "bow":
        share = travel / SPAN
        return travel + numbers["direction"] * numbers["bow"] * SPAN * share * (1.0 - share)
    middle = numbers["arm_centre"] * SPAN
    laws = {"tangent": (np.tan, np.arctan), "sine": (np.sin, np.arcsin)}
    forward, angle = laws[truth.formulation]
    longest = max(middle, SPAN - middle)
    length = longest / forward(numbers["arm_angle"])
    reach = np.clip((np.array([0.0, SPAN]) - middle) / length, -1.0, 1.0)
    first, last = angle(reach)
    limit = 1.0 if truth.formulation == "sine" else np.inf
    relative = np.clip((travel - middle) / length, -limit, limit)
    return SPAN * (angle(relative) - first) / (last - first)


def _slow(travel: Signal, clock: Clock, truth: Truth) -> Signal:
    """Reading of a slow transmitter. [m]"""
    time_constant = truth.parameters["time_constant"]
    match truth.formulation:
        case "first_order":
            return lagged(travel, clock, time_constant)
        case "second_order":
            return lagged(lagged(travel, clock, 0.5 * time_constant), clock, 0.5 * time_constant)
    raise ValueError(f"sensor_lag has no formulation {truth.formulation!r}")


def _zero_creep(clock: Clock, truth: Truth) -> Signal:
    """Change of the zero with time. [m]"""
    numbers = truth.parameters
    shape = creep_shape(clock.starts(), truth.formulation, numbers.get("time_constant", 0.0))
    return numbers["direction"] * numbers["zero_change"] * shape


def needs_fine_travel(truths: tuple[Truth, ...]) -> bool:
    """Whether the reading depends on the travel between samples."""
    return bool({"linkage_backlash", "sensor_lag"} & set(by_effect(truths, "sensor")))


def reading(travel: Signal, clock: Clock, truths: tuple[Truth, ...]) -> Signal:
    """Noise-free reading at the period starts, before it is digitised, shape (periods,). [m]"""
    effects = by_effect(truths, "sensor")
    signal = travel
    if "linkage_backlash" in effects:
        signal = _backlash(signal, effects["linkage_backlash"])
    if "linkage_nonlinearity" in effects:
        signal = _arm(signal, effects["linkage_nonlinearity"])
    if "sensor_lag" in effects:
        signal = _slow(signal, clock, effects["sensor_lag"])
    sampled = signal[:, 0].copy()
    if "sensor_drift" in effects:
        sampled += _zero_creep(clock, effects["sensor_drift"])
    return sampled


def digitised(sampled: Signal, noise: Signal, resolution: float, truths: tuple[Truth, ...]) -> Signal:
    """Reading as it is recorded: noise added, then rounded to the resolution. [m]

    A coarse `converter` rounds the noisy signal; a coarse `encoder` rounds before the noise arrives.
    """
    truth = by_effect(truths, "sensor").get("quantisation")
    if truth is None:
        return _rounded(sampled + noise, resolution, 0.0)
    coarse, phase = truth.parameters["reading_step"], truth.parameters["phase"]
    match truth.formulation:
        case "converter":
            return _rounded(sampled + noise, coarse, phase)
        case "encoder":
            return _rounded(_rounded(sampled, coarse, phase) + noise, resolution, 0.0)
    raise ValueError(f"quantisation has no formulation {truth.formulation!r}")


def _rounded(values: Signal, resolution: float, phase: float) -> Signal:
    """Values to the nearest multiple of the resolution, shifted by `phase` of it."""
    if resolution <= 0:
        return values
    return (np.round(values / resolution - phase) + phase) * resolution
