"""The effect library: a page a stage and a section an effect, from the declarations, with a picture of its trace."""

from __future__ import annotations

import io

import matplotlib as mpl
import mkdocs_gen_files
import numpy as np
from matplotlib.figure import Figure

from valvemodel.declarations import STAGES, Effect, Parameter
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.simulation import simulate
from valvemodel.stages import EFFECTS
from valvemodel.valves import read_valve

mpl.rcParams["svg.hashsalt"] = "valvemodel"

RATE = 50.0
"""Of the record behind the pictures. [Hz]"""

SHOWN = {
    "end_stop": {"upper_stop": 0.17},
    "load_force": {"load_sine": 600.0, "load_cosine": 0.0, "load_period": 7.0},
    "position_dependent_friction": {"tight_spot_excess": 2.0, "tight_spot_position": 0.12, "tight_spot_width": 0.015},
    "quantisation": {"resolution": 0.01},
    "static_friction": {"static_friction_ratio": 2.0},
    "stribeck": {"stribeck_ratio": 2.0},
    "gap_drift": {"gap_drift_rate": 2e-7},
    "sensor_drift": {"sensor_drift_rate": 5e-4},
    "friction_drift": {"friction_drift_rate": 0.02},
    "air_leak": {"leak_ratio": 0.15},
    "spring_hardening": {"spring_hardening": 8.0},
    "linkage_nonlinearity": {"linkage_bow": 0.02},
    "magnetic_hysteresis": {"hysteresis_half_width": 1e-3},
    "linkage_backlash": {"backlash_half_width": 8e-3},
    "asymmetric_friction": {"friction_asymmetry": 0.6},
    "asymmetric_viscous_friction": {"viscous_asymmetry": 0.9},
    "magnetic_saturation": {"saturation_slope": 0.5},
    "area_variation": {"area_slope": -1.0},
    "presliding": {"presliding_compliance": 3e-6},
    "supply_droop": {"droop_gain": 0.6},
}
"""Values large enough to be seen in a small picture; the others are at their typical ones. [SI]"""


def strokes() -> tuple[np.ndarray, np.ndarray]:
    """Two slow strokes, the second within the first, and steps. [s], [A]"""
    time = np.arange(0.0, 60.0, 1.0 / RATE)
    slow = np.interp(time, [0, 12, 24, 31, 38, 44], np.array([4, 20, 4, 14, 8, 8]) * 1e-3)
    steps = np.array([8, 16, 6, 18, 9])[np.clip(((time - 44.0) / 3.5).astype(int), 0, 4)] * 1e-3
    return time, np.where(time < 44.0, slow, steps)


def picture(effect: Effect) -> str:
    """Return an SVG: the loop over the current, and the last steps in time, with and without the effect."""
    valve = read_valve("calibrated")
    base = Model(valve.name, valve.values)
    model = base.with_effect(effect.key, **SHOWN.get(effect.key, {}))
    time, current = strokes()
    runs = {"base": simulate(base, time=time, current=current), "effect": simulate(model, time=time, current=current)}
    figure = Figure(figsize=(7.0, 2.6), layout="constrained")
    loop, trace = figure.subplots(1, 2)
    slow = time < 38.0
    for name, run, colour, width in (
        ("base valve", runs["base"], "0.6", 2.2),
        (f"with {effect.title}", runs["effect"], "tab:blue", 1.2),
    ):
        loop.plot(1e3 * current[slow], 1e3 * run.position[slow], color=colour, linewidth=width, label=name)
        late = time > 43.0
        trace.plot(time[late], 1e3 * run.position[late], color=colour, linewidth=width)
    loop.set(xlabel="current [mA]", ylabel="reading [mm]")
    trace.set(xlabel="time [s]", ylabel="reading [mm]")
    loop.legend(frameon=False, fontsize=8)
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def row(parameter: Parameter) -> str:
    unit = "" if parameter.unit == "1" else parameter.unit
    return (
        f"| `{parameter.name}` | {parameter.meaning} | {unit} | {parameter.low:g} .. {parameter.high:g} | "
        f"{parameter.neutral:g} | {parameter.typical:g} |"
    )


def linked(key: str) -> str:
    if key == "none":
        return "none (the base valve)"
    alias = effect_of_key(key)
    return f"[{alias.title}]({alias.stage}.md#{key})"


def section(effect: Effect) -> str:
    lines = [
        f"## {effect.title[0].upper()}{effect.title[1:]} {{ #{effect.key} }}",
        f"`{effect.key}`: {effect.meaning}.",
        f"$${effect.equation}$$",
        f"![What {effect.title} does to the loop of current and reading, and to steps](pictures/{effect.key}.svg)",
        "| parameter | meaning | unit | range | neutral | typical |\n|---|---|---|---|---|---|\n"
        + "\n".join(map(row, effect.shown)),
    ]
    if effect.aliases:
        lines.append("Comes close to it in current and position: " + ", ".join(map(linked, effect.aliases)) + ".")
    if effect.told_apart_by:
        lines.append(f"Told apart by {effect.told_apart_by}.")
    lines.append(f"Source: {effect.source}.")
    lines.append(f"    valvemodel simulate --input ramps.csv --effect {effect.key} --out out.csv")
    return "\n\n".join(lines)


for stage in STAGES:
    found = [effect for effect in EFFECTS if effect.stage == stage]
    with mkdocs_gen_files.open(f"effects/{stage}.md", "w") as page:
        page.write(f"# Effects of the {stage}\n\n" + "\n\n".join(map(section, found)) + "\n")
    for effect in found:
        with mkdocs_gen_files.open(f"effects/pictures/{effect.key}.svg", "w") as image:
            image.write(picture(effect))
