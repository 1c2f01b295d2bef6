"""Numbers of the base valve: what the fit made of each that was given, and what that one alone makes of the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.experiment import Experiment
from identification.fit import Fit
from identification.uncertainty import estimates
from valvemodel.model import Model


@dataclass(frozen=True)
class BaseNumber:
    """One fitted number of the base valve.

    Attributes
    ----------
    name, unit : str
    given, refitted, found : float [unit]
        As given, fitted without a cause, and fitted beside the cause that is shown.
    std : float or None [unit]
        Of the last; None where the records do not tell it.
    gap_as_given : float [m]
        Root mean square of the error where this number alone is put back from the last to the first.
    """

    name: str
    unit: str
    given: float
    refitted: float
    found: float
    std: float | None
    gap_as_given: float


def base_numbers(given: Model, base: Fit, found: Fit, experiments: Sequence[Experiment]) -> list[BaseNumber]:
    """Return the numbers of the base valve that were fitted, the one whose change closes most of the gap first.

    Parameters
    ----------
    given : Model
    base, found : Fit
        To all experiments: of the base alone, and with the cause that is shown.
    experiments : sequence of Experiment
    """
    numbers = [
        BaseNumber(
            each.name,
            each.unit,
            given.values[each.name],
            base.model.values[each.name],
            each.value,
            each.std,
            gap_of(replace(found, model=found.model.with_values(**{each.name: given.values[each.name]})), experiments),
        )
        for each in estimates(found)
        if each.name in given.values
    ]
    return sorted(numbers, key=lambda number: -number.gap_as_given)


def gap_of(fit: Fit, experiments: Sequence[Experiment]) -> float:
    """Return the root mean square of measured less simulated position. [m]"""
    errors = [each.position - fit.simulated_on(each).position[0] for each in experiments]
    return float(np.sqrt(np.nanmean(np.concatenate(errors) ** 2)))
