"""The curves of what is left over what it depends on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.report.amounts import percent, shown_unit
from diagnosis.report.figures import CAUSE, INK, picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH, _HEIGHT = 10.2, 2.5
_LEFT, _RIGHT, _BETWEEN = 0.07, 0.005, 0.03
_MOST = 4


def curves_picture(name: str, curves: Sequence[Mapping[str, Any]]) -> str:
    """Return the curves of one signal side by side, the one that explains most first, as SVG.

    Parameters
    ----------
    name : str
        Prefix of the ids in the markup.
    curves : sequence of mapping
        Of one signal, as diagnosis.json has them.
    """
    curves = curves[:_MOST]
    ends = np.concatenate([_band(curve) for curve in curves], axis=None)
    shown, factor = shown_unit(curves[0]["unit"], ends.tolist())
    low, high = factor * float(ends.min()), factor * float(ends.max())

    def draw(figure: Figure) -> None:
        wide = (1.0 - _LEFT - _RIGHT - (_MOST - 1) * _BETWEEN) / _MOST
        for number, curve in enumerate(curves):
            axes = figure.add_axes((_LEFT + number * (wide + _BETWEEN), 0.2, wide, 0.66))
            shown_x, factor_x = shown_unit(curve["against_unit"], curve["at"])
            at = factor_x * np.asarray(curve["at"])
            below, above = factor * _band(curve)
            axes.fill_between(at, below, above, color=CAUSE, alpha=0.22, linewidth=0)
            axes.plot(at, factor * np.asarray(curve["mean"]), color=CAUSE)
            axes.axhline(0.0, color=INK, linewidth=0.7)
            axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
            axes.set_xlabel(f"{curve['against']} [{shown_x}]")
            axes.set_title(percent(curve["share"]), fontsize=9.5, loc="right")
            if number:
                axes.tick_params(labelleft=False)
            else:
                axes.set_ylabel(f"{curve['signal']} left [{shown}]")

    return picture(name, draw, (_WIDTH, _HEIGHT))


def _band(curve: Mapping[str, Any]) -> np.ndarray:
    """Return the ends of twice the standard error about the mean, shape (2, bins)."""
    mean, error = np.asarray(curve["mean"], float), np.asarray(curve["error"], float)
    return np.stack([mean - 2.0 * error, mean + 2.0 * error])
