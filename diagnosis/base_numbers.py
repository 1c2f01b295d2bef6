"""Numbers of the base valve: what the fit made of each that was given, and what that one alone makes of the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from identification.determined.uncertainty import Estimate, rms_of
from identification.experiment import Experiment
from identification.fit import Fit, measured
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


def base_numbers(
    given: Model, base: Fit, found: Fit, told: Sequence[Estimate], experiments: Sequence[Experiment]
) -> list[BaseNumber]:
    """Return the numbers of the base valve that were fitted, the one whose change closes most of the gap first.

    Parameters
    ----------
    given : Model
    base, found : Fit
        To all experiments: of the base alone, and with the cause that is shown.
    told : sequence of Estimate
        Of the numbers of the latter.
    experiments : sequence of Experiment
    """
    masks = measured(experiments)

    def gap_with(name: str) -> float:
        put_back = found.model.with_values(**{name: given.values[name]})
        return rms_of(replace(found, model=put_back), experiments, masks)

    numbers = [
        BaseNumber(
            each.name,
            each.unit,
            given.values[each.name],
            base.model.values[each.name],
            each.value,
            each.std,
            gap_with(each.name),
        )
        for each in told
        if each.name in given.values
    ]
    return sorted(numbers, key=lambda number: -number.gap_as_given)
