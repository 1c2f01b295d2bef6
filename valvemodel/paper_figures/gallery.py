"""All figures of the paper that the model can make, each with the data behind it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from valvemodel.drawing import drawn
from valvemodel.files import write_json
from valvemodel.paper_figures.calibration import VALVES, calibrated, draw_scheme, draw_settled_loops
from valvemodel.paper_figures.comparison import compare, comparison_json, draw_comparison
from valvemodel.paper_figures.sweep import draw_sweep, sweep
from valvemodel.progress import Progress

SCHEMA = "valvemodel.figures/1"

Maker = Callable[[Path, Progress], dict[str, Any]]


def figure_5(folder: Path, progress: Progress) -> dict[str, Any]:
    """Position against current with n = 1."""
    return _sweep(folder, 5, 1.0)


def figure_6(folder: Path, progress: Progress) -> dict[str, Any]:
    """Position against current with n = 2."""
    return _sweep(folder, 6, 2.0)


def _sweep(folder: Path, number: int, factor: float) -> dict[str, Any]:
    found = sweep(number, factor)
    with drawn(folder, f"figure_{number}", size=(11.0, 8.0)) as figure:
        draw_sweep(figure, found)
    return found.as_json()


def figure_7(folder: Path, progress: Progress) -> dict[str, Any]:
    """Settled loops, simulated, where the paper's is measured."""
    found = {name: calibrated(name) for name in VALVES}
    with drawn(folder, "figure_7", size=(12.0, 5.5)) as figure:
        draw_settled_loops(figure, found)
    return {name: each.as_json() for name, each in found.items()}


def figure_8(folder: Path, progress: Progress) -> dict[str, Any]:
    """The method of self-calibration on one loop."""
    found = calibrated("calibrated")
    with drawn(folder, "figure_8", size=(8.0, 6.0)) as figure:
        draw_scheme(figure, found)
    return found.as_json()


def figure_9(folder: Path, progress: Progress) -> dict[str, Any]:
    """PID, self-calibration and SC-PID compared, simulated."""
    found = compare(progress)
    with drawn(folder, "figure_9", size=(11.0, 8.5)) as figure:
        draw_comparison(figure, found)
    return comparison_json(found)


MAKERS: dict[str, Maker] = {
    "figure_5": figure_5,
    "figure_6": figure_6,
    "figure_7": figure_7,
    "figure_8": figure_8,
    "figure_9": figure_9,
}
"""Each draws its figure into a folder and returns its data; one more figure is one more entry."""


def _part(progress: Progress, title: str, number: int) -> Progress:
    """Return how one figure reports, within its share of the whole."""
    return lambda what, share: progress(f"{title}: {what}", (number + share) / len(MAKERS))


def make_figures(folder: Path, progress: Progress) -> dict[str, Path]:
    """Write all figures as PNG and SVG, and figures.json; return their places by name."""
    data = {}
    for number, (name, make) in enumerate(MAKERS.items()):
        title = name.replace("_", " ")
        progress(title, number / len(MAKERS))
        data[name] = make(folder, _part(progress, title, number))
    write_json(folder / "figures.json", {"schema": SCHEMA, **data})
    files = ["figures.json", *(f"{name}.{kind}" for name in MAKERS for kind in ("png", "svg"))]
    return {file: folder / file for file in files}
