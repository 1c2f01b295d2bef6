"""Plots of a record or a run, on given axes or on new ones, which they return."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from valvemodel.drawing import axes_or_new
from valvemodel.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COURSE, LOOP = (7.0, 2.8), (4.6, 3.4)
"""Sizes of new figures. [in]"""


class Plotted:
    """What has a position over time and over what drives it."""

    def plot(self, axes: Axes | None = None, **style: Any) -> Axes:
        """Plot the position over time.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to; by default a new figure.
        **style : optional
            As `Axes.plot` takes it: label, color, linestyle.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If there is no time or no position.
        """
        axes = axes_or_new(axes, size=COURSE)
        axes.plot(self._signal("time"), self._position(axes), **style)
        axes.set_xlabel("time [s]")
        return _with_legend(axes, style)

    def plot_loop(self, axes: Axes | None = None, **style: Any) -> Axes:
        """Plot the position over the current, or over the force of a stem alone; arguments as of `plot`."""
        axes = axes_or_new(axes, size=LOOP)
        is_stem = getattr(self, "current", None) is None
        drive = self._signal("force") if is_stem else 1e3 * self._signal("current")
        axes.plot(drive, self._position(axes), **style)
        axes.set_xlabel("force [N]" if is_stem else "current [mA]")
        return _with_legend(axes, style)

    def _signal(self, name: str) -> np.ndarray:
        values = getattr(self, name, None)
        if values is None:
            raise InputError(f"this plot needs the {name}", "there is none", "choose another plot")
        return values

    def _position(self, axes: Axes) -> np.ndarray:
        """Return the position as it is shown, and say on the axes in which unit."""
        unit, factor = ("%", 100.0) if getattr(self, "position_unit", "m") == "%" else ("mm", 1e3)
        axes.set_ylabel(f"position [{unit}]")
        return factor * self._signal("position")


def _with_legend(axes: Axes, style: dict[str, Any]) -> Axes:
    """Show the legend where the curve has a name."""
    if "label" in style:
        axes.legend()
    return axes
