"""What a fit leaves of each record, and its picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from identification.fit import Fit
from valvemodel.drawing import INK
from valvemodel.quantities import format_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHOWN = {"m": ("mm", 1e3), "N": ("N", 1.0)}


@dataclass(frozen=True, eq=False)
class Residual:
    """Measured less modelled, of one record.

    Attributes
    ----------
    name : str
        Of the record.
    time : array, shape (n,), or None
        None for settled pairs. [s]
    values : array, shape (n,)
        NaN where nothing was measured. [unit]
    unit : str
        "m", or "N" for a force balance.
    """

    name: str
    time: np.ndarray | None
    values: np.ndarray
    unit: str = "m"


def residuals_of(fit: Fit) -> tuple[Residual, ...]:
    """Return what a fit leaves of the position of each experiment, in a free run."""
    return tuple(
        Residual(
            each.name, None if each.is_loop else each.record_time, each.position - fit.simulated_on(each).position[0]
        )
        for each in fit.problem.experiments
    )  # fmt: skip


def draw_residuals(axes: Axes, residuals: Sequence[Residual]) -> None:
    """Draw the residuals of all records over time, or over the number of the settled pair."""
    unit, factor = _SHOWN[residuals[0].unit]
    for each in residuals:
        abscissa = np.arange(1, len(each.values) + 1) if each.time is None else each.time
        rms = format_quantity(float(np.sqrt(np.nanmean(each.values**2))), each.unit, digits=3)
        axes.plot(abscissa, factor * each.values, linewidth=0.8, label=f"{each.name}: {rms} rms")
    axes.axhline(0.0, color=INK, linewidth=0.7)
    axes.set(xlabel="number of the pair" if residuals[0].time is None else "time [s]")
    axes.set_ylabel(f"measured less model [{unit}]")
    axes.legend()
