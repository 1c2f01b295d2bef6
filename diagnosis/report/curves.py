"""The curves of what is left over what it depends on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.report.amounts import percent, shown_unit
from diagnosis.report.figures import CAUSE
from diagnosis.report.svg import INK, picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTHS = {4: 10.2, 2: 5.0}
"""Width of the picture by the number of curves beside each other: on a page, on a phone. [in]"""
_ROW = 2.5
_RIGHT, _BETWEEN = 0.14, 0.32
_LEFT, _BELOW, _TALL = 0.72, 0.5, 1.65
"""Margins and height of the axes. [in]"""
_MOST = 4


def curves_picture(name: str, curves: Sequence[Mapping[str, Any]], *, is_wide: bool) -> str:
    """Return the curves of one signal, the one that explains most first, as SVG for a page or for a phone.

    Parameters
    ----------
    name : str
        Prefix of the ids in the markup.
    curves : sequence of mapping
        Of one signal, as diagnosis.json has them.
    """
    curves = curves[:_MOST]
    columns = 4 if is_wide else 2
    width, height = _WIDTHS[columns], _ROW * -(-len(curves) // columns)
    ends = np.concatenate([_band(curve) for curve in curves], axis=None)
    shown, factor = shown_unit(curves[0]["unit"], ends.tolist())
    low, high = factor * float(ends.min()), factor * float(ends.max())
    beyond = 0.05 * (high - low) or 1.0

    def draw(figure: Figure) -> None:
        wide = (width - _LEFT - _RIGHT - (columns - 1) * _BETWEEN) / columns
        for number, curve in enumerate(curves):
            row, column = divmod(number, columns)
            bottom = height - (row + 1) * _ROW + _BELOW
            left = _LEFT + column * (wide + _BETWEEN)
            axes = figure.add_axes((left / width, bottom / height, wide / width, _TALL / height))
            _draw_curve(axes, curve, factor)
            axes.set_ylim(low - beyond, high + beyond)
            if column:
                axes.tick_params(labelleft=False)
            else:
                axes.set_ylabel(f"{curve['signal']} {'needed' if curve.get('is_lead') else 'left'} [{shown}]")

    return picture(name, draw, (width, height))


def _draw_curve(axes: Axes, curve: Mapping[str, Any], factor: float) -> None:
    """Draw what is left over one quantity, its mean or single values, with the band and the share that it explains."""
    shown, factor_x = shown_unit(curve["against_unit"], curve["at"])
    at = factor_x * np.asarray(curve["at"])
    below, above = factor * _band(curve)
    if curve.get("has_single"):
        axes.vlines(at, below, above, color=CAUSE, alpha=0.22, linewidth=2.0)
        axes.plot(at, factor * np.asarray(curve["mean"]), "o", color=CAUSE, markersize=4.0)
    else:
        axes.fill_between(at, below, above, color=CAUSE, alpha=0.22, linewidth=0)
        axes.plot(at, factor * np.asarray(curve["mean"]), color=CAUSE)
    axes.axhline(0.0, color=INK, linewidth=0.7)
    axes.set_xlabel(f"{curve['against']} [{shown}]")
    axes.set_title(percent(curve["share"]), fontsize=9.5, loc="right")


def _band(curve: Mapping[str, Any]) -> np.ndarray:
    """Return the ends of twice the standard error about the mean, shape (2, bins)."""
    mean, error = np.asarray(curve["mean"], float), np.asarray(curve["error"], float)
    return np.stack([mean - 2.0 * error, mean + 2.0 * error])
