"""EMPS, the measured linear axis: published and own parameters side by side. Run `python -m
benchmarks.emps`."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from identification.inverse_dynamics import (
    StemDiagnosis,
    StemFit,
    StemSignals,
    diagnose_stem,
    fit_stem,
    prepare_signals,
)
from valvemodel.records import read_record

SYMMETRIC = {
    "stem_mass": 95.1089,
    "viscous_friction": 203.5034,
    "coulomb_friction": 20.3935,
    "spring_preload": -3.1648,
}
SYMMETRIC_ERROR, DIRECTIONAL_ERROR = 4.0834, 3.1117
DIRECTIONAL = {
    "stem_mass": 95.0,
    "viscous friction, rising": 166.7061,
    "viscous friction, falling": 240.4236,
    "Coulomb friction, rising": 20.1440,
    "Coulomb friction, falling": 20.6277,
}
"""As the benchmark's description prints them (Janot, Gautier, Brunot); see shared/data/README.md."""


def emps_file() -> Path:
    """Return where the record is: in VALVEMODEL_DATA, else in shared/data beside the checkout."""
    beside = Path(__file__).resolve().parents[1].parent / "shared" / "data"
    return Path(os.environ.get("VALVEMODEL_DATA", beside)) / "emps" / "emps.csv"


def compare(title: str, fit: StemFit, published: dict[str, float], error: float) -> Table:
    """Return a table of published and own numbers."""
    table = Table(title=title)
    for heading in ("", "published", "ours", "std", "off by"):
        table.add_column(heading, justify="left" if not heading else "right")
    own = {name: (each.value, each.std) for name, each in fit.parameters.items()} | by_direction(fit)
    for name, value in published.items():
        ours, deviation = own[name]
        std = "" if deviation is None else f"{deviation:.2g}"
        table.add_row(name, f"{value:.4f}", f"{ours:.4f}", std, f"{100.0 * (ours / value - 1.0):+.3f} %")
    off = fit.relative_error - error
    table.add_row("force error", f"{error:.4f} %", f"{fit.relative_error:.4f} %", "", f"{off:+.4f} points")
    return table


def by_direction(fit: StemFit) -> dict[str, tuple[float, None]]:
    """Return friction each way; the constant force is counted as Coulomb friction, as the benchmark does."""
    values = fit.values
    viscous, share = values["viscous_friction"], values.get("viscous_asymmetry", 0.0)
    coulomb, offset = values["coulomb_friction"], values["spring_preload"]
    return {
        "viscous friction, rising": (viscous * (1.0 + share), None),
        "viscous friction, falling": (viscous * (1.0 - share), None),
        "Coulomb friction, rising": (coulomb + offset, None),
        "Coulomb friction, falling": (coulomb - offset, None),
    }


def ranking(diagnosis: StemDiagnosis) -> Table:
    """Return the causes with their held-out errors."""
    table = Table(title="Force error on data not fitted [N], best first")
    for heading in ("effects", "probability", "held-out blocks", "second half", "gap closed", ""):
        table.add_column(heading, justify="left" if heading in ("effects", "") else "right")
    for cause in diagnosis.causes:
        closed = "" if cause.gap_closed is None else f"{100.0 * cause.gap_closed:.0f} %"
        table.add_row(
            " + ".join(cause.effects) or "none (symmetric friction)",
            f"{cause.probability:.3f}",
            f"{cause.gap_after:.3f}",
            f"{cause.gap_after_second_half:.3f}",
            closed,
            "below notice or out of bounds" if cause.is_below_notice else "",
        )
    return table


def off_by(fit: StemFit, published: dict[str, float], error: float) -> dict[str, float]:
    """Return the largest share by which a parameter is off, and the force error less the published, in points."""
    own = {name: (each.value, each.std) for name, each in fit.parameters.items()} | by_direction(fit)
    shares = [abs(own[name][0] / value - 1.0) for name, value in published.items()]
    return {"largest parameter error": max(shares), "force error, points": fit.relative_error - error}


def said_beyond(diagnosis: StemDiagnosis, symmetric: StemFit) -> list[str]:
    """Return what the best model says that the published one does not."""
    best, force = diagnosis.causes[0], diagnosis.signals.row_force
    share = best.gap_after / float(np.sqrt(np.mean(force**2)))
    said = [
        f"{' + '.join(best.effects)}: {best.gap_after:.3f} N on blocks not fitted, {100.0 * share:.2f} % of the force "
        f"({best.gap_after_second_half:.3f} N on the second half after a fit to the first); the published errors are "
        "those of fitted data"
    ]
    for name, each in best.fit.parameters.items():
        if each.std is not None:
            said.append(f"{name} {each.value:.4g} {each.unit}, std {each.std:.2g} over blocks of a second")
    asymmetry = best.fit.parameters.get("viscous_asymmetry")
    if asymmetry is not None and asymmetry.std:
        said.append(f"the viscous asymmetry is {abs(asymmetry.value) / asymmetry.std:.0f} deviations from none")
    offsets = [fit.parameters["spring_preload"] for fit in (symmetric, best.fit)]
    said.append(
        f"the constant force falls from {offsets[0].value:.2f} to {offsets[1].value:.2f} N (std {offsets[1].std:.2g}): "
        "the offset of the symmetric model stands in for what it lacks and is no preload"
    )
    said += [f"{effect} is no cause of its own: {reason}" for effect, reason in diagnosis.aliases.items()]
    runner = min(diagnosis.causes, key=lambda cause: cause.gap_after)
    said.append(
        f"{100.0 * diagnosis.remaining_share:.0f} % of the reducible gap stays: {' + '.join(runner.effects)} comes "
        f"lowest, {runner.gap_after:.3f} N, too little less to be named"
    )
    return said


def figures(signals: StemSignals) -> dict[str, Any]:
    """Return how far own parameters and force errors are off the published ones, and what the best model says."""
    symmetric, directional = fit_stem(signals), fit_stem(signals, effects=("asymmetric_viscous_friction",))
    return {
        "symmetric": off_by(symmetric, SYMMETRIC, SYMMETRIC_ERROR),
        "direction-dependent": off_by(directional, DIRECTIONAL, DIRECTIONAL_ERROR),
        "says": said_beyond(diagnose_stem(signals), symmetric),
    }


def main() -> int:
    """Print the comparison."""
    console = Console(width=120)
    file = emps_file()
    if not file.exists():
        console.print(f"no EMPS record at {file}; set VALVEMODEL_DATA to the folder that holds emps/emps.csv")
        return 2
    record = read_record(file)
    signals = prepare_signals(record)
    console.print(compare("Symmetric friction", fit_stem(signals), SYMMETRIC, SYMMETRIC_ERROR))
    directional = fit_stem(signals, effects=("asymmetric_viscous_friction",))
    console.print(compare("Direction-dependent friction", directional, DIRECTIONAL, DIRECTIONAL_ERROR))
    start = time.perf_counter()
    diagnosis = diagnose_stem(signals)
    seconds = time.perf_counter() - start
    console.print(ranking(diagnosis))
    gap = diagnosis.gap
    console.print(
        f"verdict: {diagnosis.verdict}, {' + '.join(diagnosis.causes[0].effects) or 'none'}, "
        f"in {seconds:.1f} s; "
        f"gap {gap.refitted:.3f} -> {gap.with_cause:.3f} N, noise floor {gap.noise_floor:.3f} N, "
        f"{100.0 * diagnosis.remaining_share:.0f} % of the reducible gap left"
    )
    for effect, reason in diagnosis.aliases.items():
        console.print(f"{effect} is no cause of its own: {reason}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
