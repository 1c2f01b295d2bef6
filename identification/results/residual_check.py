"""Residual check: is what a fit leaves over white, free of the input and the same in every regime?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.experiment import Experiment
from identification.fit import Fit
from identification.results.regimes import masks_of, words_of

LAGS = 20
"""Neighbours that the test of whiteness looks back on."""

INPUT_LAGS = (0, 1, 2, 5, 10, 20, 50)
"""Samples by which the input is delayed in the test against it."""

LEVEL = 0.05
"""Chance that a sound fit fails a test; the regimes share it."""

SIZE_LIMIT = 1.1
"""A residual larger than the noise by this factor holds more than the noise, whose estimate is good to some percent."""

FEWEST_SAMPLES = 10
"""A regime with fewer samples is not tested."""


@dataclass(frozen=True)
class Check:
    """One test: what it looks for in words, its statistic, the threshold at 5 %, whether the residual passes."""

    name: str
    looks_for: str
    statistic: float
    threshold: float

    @property
    def is_passed(self) -> bool:
        """Whether the statistic stays below the threshold."""
        return self.statistic < self.threshold

    def as_json(self) -> dict[str, Any]:
        """Return the part of fit.json."""
        verdict = "passed" if self.is_passed else "failed"
        return {
            "check": self.name,
            "looks_for": self.looks_for,
            "statistic": self.statistic,
            "threshold": self.threshold,
            "verdict": verdict,
        }


def residual_check(fit: Fit) -> tuple[Check, ...]:
    """Check the residuals of a fit on all that was measured, position and where there is one pressure.

    The free run is checked, or where the fit was re-anchored the re-anchored one.
    """
    checks: list[Check] = []
    experiments = list(fit.problem.experiments)
    runs = [fit.simulated_on(each, is_anchored=fit.problem.is_anchored) for each in experiments]
    positions = [
        (each.position - run.position[0]) / each.noise for each, run in zip(experiments, runs, strict=True)
    ]  # fmt: skip
    modes = [run.mode[0] for run in runs]
    checks += checks_of("position", experiments, positions, modes)
    if all(each.pressure is not None for each in experiments):
        pressures = [
            (np.asarray(each.pressure) - run.pressure[0]) / each.pressure_noise
            for each, run in zip(experiments, runs, strict=True)
        ]
        checks += checks_of("pressure", experiments, pressures, modes)
    return tuple(checks)


def checks_of(
    signal: str, experiments: Sequence[Experiment], residuals: Sequence[np.ndarray], modes: Sequence[np.ndarray]
) -> list[Check]:
    """Return the tests of one signal's residuals, each an array of shape (n,), NaN where nothing counts. [noise]"""
    size = float(np.sqrt(np.nanmean(np.concatenate(residuals) ** 2)))
    checks = [
        Check(f"{signal}: size", "root mean square over the noise", size, SIZE_LIMIT),
        _whiteness(signal, residuals),
        _input_correlation(signal, experiments, residuals),
    ]
    return checks + _by_regime(signal, experiments, residuals, modes)


def _whiteness(signal: str, residuals: Sequence[np.ndarray]) -> Check:
    """Ljung and Box (1978): squared autocorrelations, whose sum is chi-squared for white noise."""
    from scipy.special import chdtri

    statistic, degrees = 0.0, 0
    for residual in residuals:
        error = residual[np.isfinite(residual)]
        error = error - error.mean()
        count, lags = len(error), min(LAGS, len(error) // 5)
        power = max(float(error @ error), 1e-300)
        correlation = np.array([error[lag:] @ error[:-lag] for lag in range(1, lags + 1)]) / power
        statistic += count * (count + 2.0) * float(np.sum(correlation**2 / (count - np.arange(1.0, lags + 1))))
        degrees += lags
    threshold = float(chdtri(max(degrees, 1), LEVEL))
    return Check(f"{signal}: whiteness", f"correlation with {LAGS} samples before (Ljung-Box)", statistic, threshold)


def _input_correlation(signal: str, experiments: Sequence[Experiment], residuals: Sequence[np.ndarray]) -> Check:
    """Score test: samples times the share that a regression on the current and its delayed changes explains."""
    from scipy.special import chdtri

    inputs, errors = [], []
    for experiment, residual in zip(experiments, residuals, strict=True):
        change = np.diff(experiment.current, prepend=experiment.current[0])
        delayed = [np.concatenate([np.zeros(lag), change])[: len(change)] for lag in INPUT_LAGS]
        known = np.isfinite(residual)
        regressors = np.column_stack([experiment.current, *delayed])[known]
        inputs.append(regressors - regressors.mean(axis=0))
        errors.append(residual[known] - residual[known].mean())
    error = np.concatenate(errors)
    explained, _, rank, _ = np.linalg.lstsq(np.concatenate(inputs), error, rcond=1e-8)
    part = np.concatenate(inputs) @ explained
    statistic = len(error) * float(part @ part) / max(float(error @ error), 1e-300)
    threshold = float(chdtri(max(int(rank), 1), LEVEL))
    return Check(f"{signal}: input", "correlation with the current and its changes", statistic, threshold)


def _by_regime(
    signal: str, experiments: Sequence[Experiment], residuals: Sequence[np.ndarray], modes: Sequence[np.ndarray]
) -> list[Check]:
    """Test of the mean residual in each regime over its standard error; after reversals along the motion."""
    from scipy.special import ndtri

    parts: dict[str, list[np.ndarray]] = {}
    for experiment, residual, mode in zip(experiments, residuals, modes, strict=True):
        for name, mask in masks_of(experiment, mode).items():
            signed = residual * mode if name == "after_reversal" else residual
            parts.setdefault(name, []).append(signed[mask & np.isfinite(residual)])
    tested = {name: np.concatenate(pieces) for name, pieces in parts.items()}
    tested = {name: values for name, values in tested.items() if len(values) >= FEWEST_SAMPLES}
    spread = max(float(np.nanstd(np.concatenate(residuals))), 1e-300)
    threshold = float(ndtri(1.0 - 0.5 * LEVEL / max(len(tested), 1)))
    words = words_of(experiments)
    return [
        Check(
            f"{signal}: {name.replace('_', ' ')}",
            f"a mean {words[name]}",
            abs(float(values.mean())) * float(np.sqrt(len(values))) / spread,
            threshold,
        )
        for name, values in tested.items()
    ]
