"""What a fit determines: structure, sensitivities and intervals put together, parameter by parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from identification.determined.adequacy import undetermined_by
from identification.determined.bootstrap import bootstrap
from identification.determined.neighbourhood import neighbourhood_of
from identification.determined.profile import Ends, profile
from identification.determined.sampling import likely
from identification.determined.sensitivity import Direction, directions_of, sensitivity_of
from identification.determined.structure import Structure, structure_of
from identification.determined.uncertainty import (
    HARDLY_SEEN,
    UNDETERMINED_SHARE,
    Estimate,
    blocks_of,
    covariance,
    interval_quantile,
)
from identification.fit import Fit
from valvemodel.effects import is_jagged
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody
from valvemodel.records import Record

WIDEST_INTERVAL = 4.0 * UNDETERMINED_SHARE
"""A 95 % interval wider than this, four standard deviations of half the prior's, determines nothing. [prior]"""


@dataclass(frozen=True)
class Account:
    """What a fit determines.

    Attributes
    ----------
    structure : Structure
        What a record with these signals could determine at all.
    directions : tuple of Direction
        Combinations of parameters, the one that the record shows least first; none for a force balance.
    steps : dict of float
        By parameter half the width of the difference that its sensitivity was taken over, in the scaled unknown.
    is_anchored : bool
        Whether the sensitivities are those of a run put anew on the readings.
    intervals : dict
        By parameter the ends of its 95 % interval, None where it is open or nothing may be said. [SI]
    open : dict of str
        By parameter why it is not determined.
    is_jagged : bool
        Whether the error of the fit has many minima.
    profile, bootstrap : dict or None
        Intervals, and standard deviation with interval, by those means where they were asked for. [SI]
    """

    structure: Structure
    intervals: dict[str, Ends]
    open: dict[str, str]
    directions: tuple[Direction, ...] = ()
    steps: dict[str, float] = field(default_factory=dict)
    is_anchored: bool = False
    is_jagged: bool = False
    profile: dict[str, Ends] | None = None
    bootstrap: dict[str, tuple[float, float, float]] | None = None

    @property
    def interval_from(self) -> str:
        """What the intervals come from: the covariance, the profile or, in a jagged fit, samples of what is likely."""
        if self.profile is None:
            return "covariance"
        return "samples" if self.is_jagged else "profile"

    def as_json(self) -> dict[str, Any]:
        """Return the part of fit.json."""
        return {
            "structural": self.structure.as_json(),
            "numerical": {
                "combinations": [each.as_json() for each in self.directions],
                "steps": self.steps,
                "anchored": self.is_anchored,
            },
            "parameters": {
                name: {
                    "determined": name not in self.open,
                    "interval": None if ends == (None, None) else list(ends),
                    "interval_from": self.interval_from,
                    "reason": self.open.get(name),
                    "in_proportion_to": self.structure.measured_by.get(name),
                }
                for name, ends in self.intervals.items()
            },
            "profile": None if self.profile is None else {name: list(ends) for name, ends in self.profile.items()},
            "bootstrap": None
            if self.bootstrap is None
            else {name: {"std": std, "interval": ends} for name, (std, *ends) in self.bootstrap.items()},
        }


def account_of(
    fit: Fit,
    found: Sequence[Estimate],
    record: Record,
    *,
    has_profile: bool = False,
    samples: np.ndarray | None = None,
    repetitions: int = 0,
    progress: Progress = tell_nobody,
) -> Account:
    """Return what a fit to current and position determines.

    Parameters
    ----------
    fit : Fit
    found : sequence of Estimate
        Its parameters.
    record : Record
        One of those that were fitted: the signals that it has count, a pressure if one was fitted to.
    has_profile : bool
        Whether to follow the profile likelihood of each parameter.
    samples : array, shape (samples, unknowns), optional
        Of a fit whose error has many minima, in place of the profile.
    repetitions : int
        Of the bootstrap by blocks; 0 leaves it out.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.
    """
    sensitivity = sensitivity_of(fit)
    directions = tuple(directions_of(sensitivity))
    account = Account(
        structure=structure_of(record, fit.model),
        intervals={each.name: each.interval or (None, None) for each in found},
        open={each.name: _reason(each, directions) for each in found if each.reason is not None},
        directions=directions,
        steps={each.name: float(step) for each, step in zip(sensitivity.unknowns, sensitivity.steps, strict=True)},
        is_anchored=sensitivity.is_anchored,
        is_jagged=is_jagged(fit.model.effects),
    )
    near = neighbourhood_of(fit) if has_profile or repetitions else None
    if has_profile and near is not None:
        # Between many minima no refit of the others can be trusted: what is likely was sampled instead.
        ends = profile(near, limits_of(fit), progress) if samples is None else likely(fit.unknowns, samples)
        account = _profiled(account, fit, ends)
    if repetitions and near is not None:
        account = replace(account, bootstrap=bootstrap(near, repetitions, progress))
    return account


def account_of_stem(
    record: Record, model: Model, found: Sequence[Estimate], reasons: dict[str, str], *, blocks: int
) -> Account:
    """Return what a force balance of the stem determines: its errors are those of a jackknife over so many blocks."""
    quantile = interval_quantile(blocks)
    intervals: dict[str, Ends] = {
        each.name: (None, None)
        if each.std is None
        else (each.value - quantile * each.std, each.value + quantile * each.std)
        for each in found
    }
    return Account(structure_of(record, model), intervals, reasons)


def _reason(estimate: Estimate, directions: Sequence[Direction]) -> str:
    """Say why a parameter is not determined, and together with what where others could make up for it."""
    assert estimate.reason is not None
    if estimate.reason != HARDLY_SEEN:
        return estimate.reason
    for direction in directions:
        if not direction.is_determined and estimate.name in direction.names[1:]:
            return f"only together with {direction.names[0]}"
        if not direction.is_determined and estimate.name in direction.names and len(direction.names) > 1:
            return f"only together with {', '.join(direction.names[1:])}"
    return estimate.reason


def _profiled(account: Account, fit: Fit, ends: dict[str, Ends]) -> Account:
    """Take the profile's intervals: one that is open, or as wide as the prior, says nothing of its parameter.

    What the experiments cannot tell stays open, however narrow its interval is.
    """
    reasons, lacking = {}, undetermined_by(fit.problem.experiments)
    for unknown in fit.unknowns:
        low, high = ends.get(unknown.name, (unknown.centre, unknown.centre))
        if unknown.name in lacking:
            reasons[unknown.name] = lacking[unknown.name]
        elif low is None or high is None:
            side = "either way" if low is high else "downwards" if low is None else "upwards"
            reasons[unknown.name] = f"its interval is open {side}"
        elif unknown.scaled(high) - unknown.scaled(low) > WIDEST_INTERVAL * unknown.prior_spread:
            reasons[unknown.name] = account.open.get(unknown.name, HARDLY_SEEN)
    return replace(account, intervals=ends, open=reasons, profile=ends)


def limits_of(fit: Fit) -> np.ndarray:
    """Return by how much twice the error may rise within each unknown's interval, shape (unknowns,).

    The square of the quantile, widened as much as the block-robust variance is wider than that of white noise of the
    stated level.
    """
    block = blocks_of(fit)
    quantile = interval_quantile(len(np.unique(block[block >= 0])))
    jacobian = fit.problem.jacobian(fit.found.point)
    residual = fit.problem.residuals(fit.found.point[None, :])[0]
    robust = np.diag(covariance(jacobian, residual, block))
    plain = np.diag(np.linalg.pinv(jacobian.T @ jacobian, hermitian=True))
    return quantile**2 * robust / np.maximum(plain, 1e-300)
