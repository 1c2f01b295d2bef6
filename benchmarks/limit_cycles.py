"""Error map of the describing function and of the return map, against the exact simulator (see `main`)."""

from __future__ import annotations

import json
import os
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CURRENT = 12e-3
"""At which all loops work. [A]"""

RATIOS = (1.05, 1.1, 1.2, 1.5, 2.0)
"""F_s / F_c."""

LAG, DEAD_TIME = 5.0, 1.0
"""Of the process. [s]"""

SAMPLES = 20000.0
"""Controller periods in one turn, within the bounds of the family."""


@dataclass(frozen=True)
class Family:
    """Loops that differ in one gain: its values, the gains of PI over the valve's inverse static gain, the process.

    The controller's periods are short against a slip, which takes some 10 ms, or against the process. [s]
    """

    title: str
    axis: str
    levels: tuple[float, ...]
    proportional: float
    integral: float
    lag: float = 0.0
    dead_time: float = 0.0
    scales_both: bool = False
    periods: tuple[float, float] = (1e-4, 1e-3)


FAMILIES = {
    "integral": Family(
        "integral control of the valve", "integral gain x static gain [1/s]", (0.3, 1.0, 3.0, 10.0, 20.0), 0.0, 1.0
    ),
    "proportional_integral": Family(
        "PI control of the valve, proportional gain x static gain = 1", "integral gain x static gain [1/s]",
        (0.3, 1.0, 3.0, 10.0, 20.0), 1.0, 1.0,
    ),
    "process": Family(
        f"PI around a lag of {LAG:g} s and a dead time of {DEAD_TIME:g} s", "gain over Skogestad's [1]",
        (0.25, 0.5, 0.75, 1.0, 1.5, 2.0), LAG / (2.0 * DEAD_TIME), 0.5 / DEAD_TIME, LAG, DEAD_TIME, True,
        (2e-3, 1e-2),
    ),
}  # fmt: skip


def examine(task: tuple[str, str, float, float]) -> dict[str, Any]:
    """Compare the three answers on one loop: valve set, family, level of its gain and friction ratio."""
    from valvemodel.linear import Loop, linearise
    from valvemodel.linear.comparison import compare
    from valvemodel.linear.limit_cycle import describing_cycle
    from valvemodel.linear.report import loop_content
    from valvemodel.model import Model
    from valvemodel.valves import read_valve

    valve_name, family_name, level, ratio = task
    family, valve = FAMILIES[family_name], read_valve(valve_name)
    model = Model(valve.name, valve.values, {"static_friction": {"static_friction_ratio": ratio}})
    gain = float(linearise(model, current=CURRENT).current_to_position.dcgain())
    proportional = family.proportional * (level if family.scales_both else 1.0) / gain
    integral = family.integral * level / gain
    loop = Loop(model, CURRENT, proportional, integral, family.lag, family.dead_time, family.periods[1])
    guess = describing_cycle(loop)
    turn = guess.period if guess else 4.0 * (ratio + 1.0) / (level * (ratio - 1.0))
    period = float(np.clip(turn / SAMPLES, *family.periods))
    period = family.dead_time / round(family.dead_time / period) if family.dead_time else period
    loop = Loop(model, CURRENT, proportional, integral, family.lag, family.dead_time, period)
    began = time.perf_counter()
    content = loop_content(loop, compare(loop))
    return {
        "valve": valve_name, "family": family_name, "level": level, "friction_ratio": ratio, **content,
        "seconds": time.perf_counter() - began,
    }  # fmt: skip


def draw(results: list[dict[str, Any]], valve: str, folder: Path) -> None:
    """Draw the error map of one valve set."""
    from valvemodel.drawing import drawn

    columns = (
        ("describing_function", "period", "describing function: error of the period [%]"),
        ("describing_function", "amplitude", "describing function: error of the amplitude [%]"),
        ("return_map", "period", "return map: error of the period [%]"),
    )
    with drawn(folder, f"limit_cycles_{valve}", size=(15.0, 12.0)) as figure:
        for axes, (name, family) in zip(figure.subplots(len(FAMILIES), 3), FAMILIES.items(), strict=True):
            chosen = [each for each in results if each["valve"] == valve and each["family"] == name]
            for place, (method, quantity, title) in zip(axes, columns, strict=True):
                _draw_map(place, family, chosen, method, quantity)
                place.set_title(f"{title}\n{family.title}", fontsize=9)
        figure.suptitle(
            f"Limit cycles of `{valve}` at {1e3 * CURRENT:g} mA: errors against the exact simulation\n"
            "missed: only the simulation settles into a cycle; false: only the prediction; none: neither, "
            "the stem wanders or rests"
        )


def _draw_map(axes: Axes, family: Family, results: list[dict[str, Any]], method: str, quantity: str) -> None:
    errors = np.full((len(RATIOS), len(family.levels)), np.nan)
    for each in results:
        row, column = RATIOS.index(each["friction_ratio"]), family.levels.index(each["level"])
        judged = each["errors"][method]
        errors[row, column] = 100.0 * judged[quantity]
        if np.isfinite(errors[row, column]):
            is_dark = abs(errors[row, column]) > 30.0
            digits = 0 if method == "describing_function" else 2
            words, colour = f"{errors[row, column]:+.{digits}f}", "white" if is_dark else "black"
        else:
            words, colour = judged["verdict"], "black"
        axes.text(column, row, words, ha="center", va="center", color=colour, fontsize=8.5)
    axes.imshow(errors, origin="lower", aspect="auto", cmap="PuOr", vmin=-60.0, vmax=60.0)
    axes.grid(visible=False)
    axes.set_xticks(range(len(family.levels)), [f"{level:g}" for level in family.levels])
    axes.set_yticks(range(len(RATIOS)), [f"{ratio:g}" for ratio in RATIOS])
    axes.set_xlabel(family.axis)
    axes.set_ylabel("static over Coulomb friction")


def summary(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Return for each valve set and family how often each prediction errs, and by how much."""
    found: dict[str, Any] = {}
    for valve in sorted({each["valve"] for each in results}):
        for name in FAMILIES:
            chosen = [each for each in results if each["valve"] == valve and each["family"] == name]
            found[f"{valve}, {name}"] = {method: _tally(chosen, method) for method in chosen[0]["errors"]}
    return found


def _tally(results: list[dict[str, Any]], method: str) -> dict[str, Any]:
    judged = [each["errors"][method] for each in results]
    verdicts = [each["verdict"] for each in judged]
    errors = [abs(each["period"]) for each in judged if np.isfinite(each["period"])]
    return {
        **{verdict: verdicts.count(verdict) for verdict in ("both cycle", "missed", "false", "none")},
        "median_error_of_period": float(np.median(errors)) if errors else None,
        "largest_error_of_period": max(errors, default=None),
    }


@click.command()
@click.option("--valve", "valves", multiple=True, default=("linear", "calibrated"), show_default=True)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for figures and limit_cycles.json.")
@click.option("--jobs", default=2, show_default=True)
def main(valves: tuple[str, ...], out: Path, jobs: int) -> None:
    """Examine the grid, and write figures and numbers: `python -m benchmarks.limit_cycles --out DIR`."""
    from valvemodel.files import make_folder, write_json

    tasks = [
        (valve, name, level, ratio)
        for valve in valves
        for name, family in FAMILIES.items()
        for level in family.levels
        for ratio in RATIOS
    ]
    with ProcessPoolExecutor(jobs, mp_context=get_context("fork")) as pool:
        results = []
        with click.progressbar(pool.map(examine, tasks), length=len(tasks), label="loops") as bar:
            results = list(bar)
    make_folder(out)
    for valve in valves:
        draw(results, valve, out)
    tallies = summary(results)
    write_json(out / "limit_cycles.json", {"summary": tallies, "loops": results})
    click.echo(json.dumps(tallies, indent=1))


if __name__ == "__main__":
    main()
