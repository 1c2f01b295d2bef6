"""How figures look: colours that all can tell apart, and the files that they are saved to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"
"""Okabe and Ito's colours."""

INK, GREY = "#222222", "#8a8a8a"

RESOLUTION = 130
"""Of bitmaps. [1/in]"""

_SETTINGS: dict[Any, Any] = {
    "font.size": 9.5,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "figure.titlesize": 12,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "svg.fonttype": "none",
    "svg.hashsalt": "valvemodel",
}


@contextmanager
def drawn(folder: Path, name: str, *, size: tuple[float, float]) -> Iterator[Figure]:
    """Open a figure that is saved as name.png and name.svg when it is done; size in inches.

    Nothing is written where drawing fails.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(_SETTINGS):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure
        figure.savefig(folder / f"{name}.png", dpi=RESOLUTION)
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})


def axes_or_new(axes: Axes | None, *, size: tuple[float, float]) -> Axes:
    """Return the axes that were given, or those of a new figure of pyplot's, as a notebook shows it; size in inches."""
    if axes is not None:
        return axes
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    with mpl.rc_context(_SETTINGS):
        return plt.subplots(figsize=size, layout="constrained")[1]
