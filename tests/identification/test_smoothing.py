"""A signal without its noise: nearer to what it was than with any one window, jumps and corners included."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_filter

from identification.driving.smoothing import WINDOWS, smoothed

NOISE = 0.01

PLACES = np.arange(3000.0)

SHAPES = {
    "level": np.full(3000, 1.0),
    "ramp": 0.002 * PLACES,
    "wave": np.sin(PLACES / 60.0),
    "corners": np.abs((PLACES % 400.0) - 200.0) / 200.0,
    "jumps": np.floor(PLACES / 250.0) % 2.0,
}


def noisy(signal: np.ndarray, seed: int = 0) -> np.ndarray:
    return signal + NOISE * np.random.default_rng(seed).standard_normal(len(signal))


def off(found: np.ndarray, signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found - signal) ** 2)))


@pytest.mark.parametrize(("shape", "share"), [("level", 0.15), ("ramp", 0.2), ("wave", 0.35), ("corners", 0.25)])
def test_most_of_the_noise_is_gone(shape: str, share: float):
    signal = SHAPES[shape]
    assert off(smoothed(noisy(signal), NOISE), signal) < share * NOISE


def test_jumps_stay_in_their_row():
    signal = SHAPES["jumps"]
    found = smoothed(noisy(signal), NOISE)
    assert np.array_equal(found > 0.5, signal > 0.5)
    assert np.abs(found - signal).max() < 5.0 * NOISE


def test_it_is_nearer_than_any_one_window():
    signal = np.concatenate(list(SHAPES.values()))
    measured = noisy(signal, 1)
    fixed = [
        off(savgol_filter(measured, 2 * reach + 1, order), signal)
        for reach in WINDOWS
        for order in (0, 1, 2)
        if 2 * reach + 1 > order
    ]
    assert off(smoothed(measured, NOISE), signal) < 0.5 * min(fixed)


def test_a_signal_of_few_samples_is_taken():
    assert len(smoothed(np.array([1.0, 2.0, 1.5]), NOISE)) == 3
    assert smoothed(np.array([1.0]), NOISE) == pytest.approx([1.0])


def test_what_differs_by_far_more_than_noise_everywhere_stays():
    wild = np.random.default_rng(2).uniform(0.0, 1.0, 400)
    assert off(smoothed(wild, 1e-6), wild) < 1e-6
