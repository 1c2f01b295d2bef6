"""The heat map of confusability: which effect could pass for which under an input."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.report.figures import CAUSE
from diagnosis.report.naming import effect_title
from diagnosis.report.svg import INK, picture, readable_on

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROW = 0.23
_MARGINS = 2.3, 1.75, 0.45
"""Left of the matrix, above and below it. [in]"""
_WIDTH = 10.2


def heat_map_picture(name: str, confusability: Mapping[str, Any]) -> str:
    """Return the similarity of all effects, with the visibility of each beside it, as SVG.

    Parameters
    ----------
    name : str
        Prefix of the ids in the markup.
    confusability : mapping
        As diagnosis.json has it.
    """
    labels = [effect_title(key) for key in confusability["effects"]]
    similarity = np.array(confusability["similarity"], dtype=float)
    left, above, below = _MARGINS
    height = _ROW * len(labels) + above + below
    bottom, tall = below / height, _ROW * len(labels) / height

    def draw(figure: Figure) -> None:
        matrix = figure.add_axes((left / _WIDTH, bottom, 0.565, tall))
        bars = figure.add_axes((left / _WIDTH + 0.585, bottom, 0.17, tall))
        _draw_matrix(matrix, labels, similarity, confusability["alike_from"])
        _draw_bars(bars, np.array(confusability["visibility"], dtype=float))

    return picture(name, draw, (_WIDTH, height))


def _draw_matrix(axes: Axes, labels: list[str], similarity: np.ndarray, alike: float) -> None:
    shade = 1.0 - np.clip((similarity - 0.5) / 0.5, 0.0, 1.0)[..., None] * (1.0 - np.array([0.0, 0.27, 0.45]))
    shade[~np.isfinite(similarity)] = 0.93
    np.einsum("iij->ij", shade)[:] = 0.85
    axes.imshow(shade, aspect="auto", interpolation="nearest")
    for row, column in zip(*np.nonzero(similarity >= 0.7), strict=True):
        if row != column:
            cosine = similarity[row, column]
            axes.text(
                column, row, f"{100 * min(cosine, 0.99):.0f}", ha="center", va="center", fontsize=7.5,
                color=readable_on(shade[row, column]), fontweight="bold" if cosine >= alike else "normal",
            )  # fmt: skip
    axes.set_yticks(range(len(labels)), labels)
    axes.set_xticks(range(len(labels)), labels, rotation=58, ha="left", rotation_mode="anchor")
    axes.xaxis.tick_top()
    axes.tick_params(length=0, labelsize=8.5)
    axes.grid(visible=False)
    edges = np.arange(-0.5, len(labels))
    axes.hlines(edges, edges[0], edges[-1], colors="white", linewidths=0.6)
    axes.vlines(edges, edges[0], edges[-1], colors="white", linewidths=0.6)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("similarity of the traces [%]: how well the column's effect could imitate the row's")
    axes.xaxis.set_label_position("bottom")


def _draw_bars(axes: Axes, visibility: np.ndarray) -> None:
    rows = np.arange(len(visibility))
    axes.barh(rows, np.maximum(visibility, 0.05), height=0.62, color=CAUSE, left=0.05)
    axes.axvline(1.0, color=INK, linewidth=0.9, linestyle=(0, (4, 2)))
    axes.set_xscale("log")
    axes.set_xlim(0.05, max(100.0, 1.5 * float(visibility.max())))
    axes.set_ylim(len(visibility) - 0.5, -0.5)
    axes.set_yticks([])
    axes.set_xticks([0.1, 1.0, 10.0, 100.0], ["0.1", "1", "10", "100"])
    axes.minorticks_off()
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("trace over noise")
