"""Residual curves: what the refitted base leaves at each stage, and what that depends on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from diagnosis.score import persistence_of
from diagnosis.whereabouts.breakaway_curves import curves_of_breakaways
from diagnosis.whereabouts.curve import Curve
from diagnosis.whereabouts.own_signals import Explained
from identification.experiment import Experiment
from identification.fit import Fit, simulate_model
from identification.inverse_dynamics import fit_stem, prepare_signals
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.records import Record

SEEN_BY = {
    "electromagnet": ("current", "time"),
    "nozzle": ("pressure", "time"),
    "stem": ("position", "speed", "pressure", "time"),
    "sensor": ("position", "speed", "time"),
}
"""Quantities over which what a stage would have to do by its own signals is shown."""

STILL = 1e-7
"""A stem rests that moves less in a period. [m]"""

BINS = 16
FEWEST = 12
"""Samples below which a bin says nothing."""

WIDEST = 4.5
"""A residual counts up to this many times its median absolute value, three standard deviations of a normal one."""


def residual_curves(experiments: Sequence[Experiment], base: Fit, explained: Sequence[Explained] = ()) -> list[Curve]:
    """Return what the residuals depend on, for each signal the quantity first that explains most.

    What stages would have to do by their own signals comes last, but for signals whose residual was measured.

    Position and, where measured, pressure are compared with the base's own run; the gap is that which the measured
    pressure takes at rest, less that which the current makes; the force is the measured pressure's on the diaphragm,
    less what mass, spring and friction take (least squares while the stem moves). What it takes to break away is shown
    where one force does not explain it.
    """
    curves = list(curves_of_run(experiments, base))
    if all(experiment.pressure is not None for experiment in experiments):
        curves += curves_of_force(experiments, base.model)
    curves += curves_of_breakaways(base)
    measured = {curve.signal for curve in curves}
    curves += [curve for curve in curves_of_own_signals(explained) if curve.signal not in measured]
    signals = dict.fromkeys(curve.signal for curve in curves)
    return [
        curve
        for signal in signals
        for curve in sorted((each for each in curves if each.signal == signal), key=lambda each: -each.share)
    ]


def curves_of_run(experiments: Sequence[Experiment], base: Fit) -> Iterator[Curve]:
    """Yield the curves of position, pressure and gap."""
    runs = [base.simulated_on(experiment) for experiment in experiments]
    quantities = {
        "current": ("A", _joined([each.current for each in experiments])),
        "position": ("m", _joined([run.position[0] for run in runs])),
        "speed": ("m/s", _joined([_slope(r.position[0], e.time) for r, e in zip(runs, experiments, strict=True)])),
        "time": ("s", _joined([each.record_time for each in experiments])),
    }
    off = _joined([each.position - run.position[0] for each, run in zip(experiments, runs, strict=True)])
    measured = _joined([each.pressure for each in experiments if each.pressure is not None])
    has_pressure = len(measured) == len(off)
    yield from curves_against("position", "m", "stem or sensor" if has_pressure else "any", off, quantities)
    if not has_pressure:
        return
    before_stem = {name: quantities[name] for name in ("current", "time")} | {"pressure": ("Pa", measured)}
    off = measured - _joined([run.pressure[0] for run in runs])
    yield from curves_against("pressure", "Pa", "electromagnet or nozzle", off, before_stem)
    made = _joined([run.pressure[0] for run in runs])
    gap = gap_at(measured, base.model) - gap_at(made, base.model)
    yield from curves_against("gap", "m", "electromagnet or nozzle", gap, before_stem)


def curves_of_force(experiments: Sequence[Experiment], model: Model) -> Iterator[Curve]:
    """Yield the curves of the force on the stem and of that against its motion; none where the stem hardly moves."""
    residuals: list[np.ndarray] = []
    directions: list[np.ndarray] = []
    quantities: dict[str, list[np.ndarray]] = {"position": [], "speed": [], "time": [], "pressure": []}
    for each in experiments:
        assert each.pressure is not None
        time, pressure, position = _without_gaps(each.time, each.pressure, each.position)
        force = model.values["diaphragm_area"] * pressure
        try:
            signals = prepare_signals(Record.from_arrays(each.name, time=time, force=force, position=position))
            residuals.append(fit_stem(signals).residual)
        except InputError:
            return
        directions.append(np.sign(signals.decimate(signals.direction)))
        quantities["position"].append(signals.decimate(signals.position))
        quantities["speed"].append(signals.decimate(signals.velocity))
        quantities["time"].append(signals.row_time)
        quantities["pressure"].append(signals.row_force / model.values["diaphragm_area"])
    units = {"position": "m", "speed": "m/s", "time": "s", "pressure": "Pa"}
    against = {name: (units[name], _joined(parts)) for name, parts in quantities.items()}
    residual, direction = _joined(residuals), _joined(directions)
    yield from curves_against("force", "N", "stem", residual, against)
    yield from curves_against("friction", "N", "stem", residual * direction, against)


def _without_gaps(time: np.ndarray, *signals: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return times and signals, shape (n,) each, from where all have begun to where one ends, straight over gaps."""
    known = [np.flatnonzero(np.isfinite(signal)) for signal in signals]
    rows = slice(max(each[0] for each in known), min(each[-1] for each in known) + 1)
    filled = [np.interp(time[rows], time[each], signal[each]) for each, signal in zip(known, signals, strict=True)]
    return time[rows], *filled


def curves_of_own_signals(explained: Sequence[Explained]) -> Iterator[Curve]:
    """Yield the curves of what each stage would have to do by its own signals, beyond what its own numbers can.

    Of the functions of these those of the kind are taken that explains most by itself. The force is what the stem would
    have to overcome beside spring and friction, taken while it moves.
    """
    for each in explained:
        experiment, lead = each.experiment, each.lead
        values = lead.model.values
        run = simulate_model(lead.model, experiment, start_position=lead.start)
        pressure, position = experiment.held_from(run.pressure[0]), run.position[0]
        speed = _slope(position, experiment.time)
        moves = np.diff(position, append=position[-1])
        direction = np.where(np.abs(moves) > STILL, np.sign(moves), np.nan)
        force = beyond(-values["spring_rate"] * lead.values * np.abs(direction), position, speed, direction)
        shift = lead.values * values["spring_rate"] / values["diaphragm_area"]
        opening, unit, moved = opening_of(lead.model, pressure, shift)
        by_current = experiment.current if opening == "current" else np.sqrt(experiment.current)
        signals = {
            "electromagnet": {opening: (unit, beyond(moved, by_current))},
            "nozzle": {"pressure": ("Pa", beyond(shift, pressure))},
            "stem": {"force": ("N", force), "friction": ("N", force * direction)},
            "sensor": {"reading": ("m", beyond(lead.values, position))},
        }
        quantities = {
            "current": ("A", experiment.current),
            "pressure": ("Pa", pressure),
            "position": ("m", position),
            "speed": ("m/s", speed),
            "time": ("s", experiment.record_time),
        }
        against = {name: quantities[name] for name in SEEN_BY[each.stage] if name != "time" or not experiment.is_loop}
        for signal, (unit, residual) in signals[each.stage].items():
            for curve in curves_against(signal, unit, each.stage, residual, against):
                yield replace(curve, is_lead=True)


def beyond(residual: np.ndarray, *terms: np.ndarray) -> np.ndarray:
    """Return a residual less its least-squares fit by a constant and some terms, shape (n,); NaN where it is."""
    known = np.isfinite(residual)
    columns = np.stack([np.ones(len(residual)), *terms], axis=1)
    left = np.full(len(residual), np.nan)
    left[known] = residual[known] - columns[known] @ np.linalg.lstsq(columns[known], residual[known])[0]
    return left


def curves_against(
    signal: str, unit: str, stage: str, residual: np.ndarray, quantities: Mapping[str, tuple[str, np.ndarray]]
) -> Iterator[Curve]:
    """Yield the mean of a residual over each quantity, in bins of equal count."""
    known = np.isfinite(residual)
    if not known.any():
        return
    residual = without_outliers(residual[known])
    lasting = persistence_of(residual)
    whole = float(residual @ residual) or 1.0
    for name, (quantity_unit, values) in quantities.items():
        values = values[known]
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)))
        number = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, max(len(edges) - 2, 0))
        counts = np.bincount(number)
        kept = np.flatnonzero(counts >= FEWEST)
        if not kept.size:
            continue
        at, mean = (np.bincount(number, each)[kept] / counts[kept] for each in (values, residual))
        square = np.bincount(number, residual**2)[kept] / counts[kept] - mean**2
        error = np.sqrt(np.maximum(square, 0.0) * lasting / counts[kept])
        share = float(np.sum(counts[kept] * mean**2)) / whole
        yield Curve(signal, unit, stage, name, quantity_unit, at, mean, error, share)


def without_outliers(residual: np.ndarray) -> np.ndarray:
    """Return a residual about 0, its rare large values cut down: a jump in a fast stroke says nothing of a curve."""
    residual = residual - np.median(residual)
    widest = WIDEST * float(np.median(np.abs(residual)))
    clipped = np.clip(residual, -widest, widest)
    return clipped - clipped.mean()


def opening_of(model: Model, pressure: np.ndarray, shift: np.ndarray) -> tuple[str, str, np.ndarray]:
    """Return what the electromagnet would have to do for a shift of pressures: signal, unit and values, shape (n,).

    Where the current makes the pressure by an affine map that is a current, else a gap.

    Parameters
    ----------
    model : Model
    pressure, shift : arrays, shape (n,) [Pa]
    """
    if model.values["pressure_per_current"] > 0.0:
        return "current", "A", shift / model.values["pressure_per_current"]
    return "gap", "m", gap_at(pressure + shift, model) - gap_at(pressure, model)


def gap_at(pressure: np.ndarray, model: Model) -> np.ndarray:
    """Return the gap at which the nozzle rests at a pressure, NaN outside 0 to supply. [m]

    References
    ----------
    Paper eq. (16) solved for the gap.
    """
    supply = model.values["supply_pressure"]
    inside = (pressure > 0.0) & (pressure < supply)
    ratio = supply / np.where(inside, pressure, supply) - 1.0
    return np.where(inside, np.sqrt(ratio / model.values["flow_ratio"]), np.nan)


def _slope(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    return np.gradient(values, time)


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.concatenate(parts) if parts else np.empty(0)
