"""What a fit comes to: parameters with uncertainty, errors on fitted and unseen data, what stays open."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from identification.determined.account import Account, account_of, account_of_stem
from identification.determined.sampling import sampled
from identification.display import fit_card, parameter_columns
from identification.driving.between_rows import may_have_moved, moving_between_rows, said_of_motion
from identification.driving.measured_current import as_set, may_be_noisy, said_of_current
from identification.exact_fit import fit_exact
from identification.experiment import Experiment
from identification.fit import Fit, fit_base, fitted_to_all, measured
from identification.holdout import EVERY, Holdout, hold_out
from identification.loop_shape import SAYS_NOTHING_OF_TIME, FittedShape, shape_of_fit
from identification.residual import Residual, draw_residuals, residuals_of
from identification.residual_check import Check, residual_check
from identification.timing import experiments_of
from identification.uncertainty import AT_A_BOUND, HARDLY_SEEN, Estimate, estimates, rms_of
from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.display import Card, Shown
from valvemodel.drawing import axes_or_new
from valvemodel.effects import effect_of_key, is_jagged
from valvemodel.errors import InputError, unknown_name
from valvemodel.files import write_json
from valvemodel.loops import SETTLING_EFFECTS
from valvemodel.model import Model
from valvemodel.plots import COURSE
from valvemodel.records import Record
from valvemodel.records.several import check_one_kind, told_apart

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from identification.smooth_fit import Smoothing

SCHEMA = "valvemodel.fit/1"

_STEM_ALONE = ("spring_rate", "spring_preload", "travel_min", "travel_max", "rated_travel")
"""Base parameters that a force balance settles or does not need, fitted or not."""

ROUTES = ("exact", "smooth")

Progress = Callable[[str, float], None]


@dataclass(frozen=True, repr=False)
class Outcome(Shown):
    """All that `fit.json` and `model.json` hold, in SI units.

    Attributes
    ----------
    records : tuple of str
        Their names; of those that were named alike the second is `name (2)`.
    parameters : tuple of Estimate
        Those that were fitted.
    model : Model or None
        With them; None where they make no valve that physics allows.
    rms_fitted, rms_unseen : float, float or None
        Of the final fit on all data, and of a fit to a part of them on the rest; None where nothing could be
        kept back. [unit]
    unseen : str or None
        What was kept back.
    noise : float or None
        Of the readings, estimated from themselves. [unit]
    starts : dict of float
        Fitted reading at the start of each record. [m]
    open : dict of str
        By parameter why the records do not determine it.
    loop : FittedShape or None
        Width, slope and height, where the records are settled loops.
    determined : Account
        What the records determine, before and after the fit.
    checks : tuple of Check
        Of the residuals; none for a force balance.
    route : str
        How it was searched: "exact" or "smooth".
    smoothing : tuple of Smoothing
        What smoothing did to the fit, by width; empty on the exact route.
    residuals : tuple of Residual
        What the fit leaves of each record.
    """

    records: tuple[str, ...]
    effects: tuple[str, ...]
    parameters: tuple[Estimate, ...]
    model: Model | None
    unit: str
    rms_fitted: float
    rms_unseen: float | None
    unseen: str | None
    noise: float | None
    starts: dict[str, float]
    open: dict[str, str]
    warnings: tuple[str, ...]
    seconds: float
    determined: Account
    checks: tuple[Check, ...] = ()
    route: str = "exact"
    smoothing: tuple[Smoothing, ...] = ()
    loop: FittedShape | None = None
    residuals: tuple[Residual, ...] = ()

    def to_pandas(self) -> pandas.DataFrame:
        """Return a DataFrame of the parameters in SI units: value, std, ends of the 95 % interval, whether determined.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        from valvemodel.records.frame import make_frame

        return make_frame(parameter_columns(self), index=[each.name for each in self.parameters])

    def plot_residuals(self, axes: Axes | None = None) -> Axes:
        """Plot measured less modelled over time on axes, by default of a new figure, and return them."""
        axes = axes_or_new(axes, size=COURSE)
        draw_residuals(axes, self.residuals)
        return axes

    def _card(self) -> Card:
        return fit_card(self)

    def as_json(self) -> dict[str, Any]:
        """Return the content of fit.json."""
        return {
            "schema": SCHEMA,
            "parameters": {
                each.name: {
                    "value": each.value,
                    "unit": each.unit,
                    "std": each.std,
                    "at_bound": each.is_at_bound,
                }
                for each in self.parameters
            },
            "rms": {"fitted": self.rms_fitted, "unseen": self.rms_unseen, "unit": self.unit},
            "unseen": self.unseen,
            "noise": {"value": self.noise, "unit": self.unit},
            "effects": list(self.effects),
            "not_determined": self.open,
            "determined": self.determined.as_json(),
            "residual_check": [each.as_json() for each in self.checks],
            "start_positions": {name: {"value": start, "unit": "m"} for name, start in self.starts.items()},
            **({} if self.loop is None else {"loop": self.loop.as_json()}),
            "records": list(self.records),
            "warnings": list(self.warnings),
            "seconds": self.seconds,
            "route": self.route,
            "smoothing": [each.as_json() for each in self.smoothing],
        }

    def write(self, folder: Path) -> dict[str, Path]:
        """Write fit.json and, where there is a model, model.json; return their places by name."""
        places = {"fit.json": folder / "fit.json"}
        if self.model is not None:
            places["model.json"] = folder / "model.json"
            self.model.write(places["model.json"])
        write_json(places["fit.json"], self.as_json())
        return places


def fit_records(
    records: Sequence[Record],
    model: Model,
    *,
    effects: Sequence[str] = (),
    is_ramped: bool = False,
    has_profile: bool = False,
    repetitions: int = 0,
    route: str = "exact",
    progress: Progress = lambda what, share: None,
) -> Outcome:
    """Fit a valve's free parameters, and those of effects, to its records.

    Parameters
    ----------
    records : sequence of Record
        Of one valve, all of one kind: time records, settled loops or of the stem alone. With one, blocks in time are
        kept back for the error on unseen data; with several, the last.
    model : Model
        The valve as given: where the search begins, and what gives the numbers that are not fitted.
    effects : sequence of str
        Keys of effects to switch on and fit, in this order.
    is_ramped : bool
        Whether the current of settled loops ramps slowly from value to value, instead of stepping.
    has_profile : bool
        Whether to follow the profile likelihood of each parameter to the ends of its interval.
    repetitions : int
        Of a bootstrap by blocks in time; 0 leaves it out.
    route : str
        "exact": on the exact simulator; "smooth": on smooth functions with exact derivatives, then once more on the
        exact simulator, which says what smoothing did. Records of the stem alone have one route of their own.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Raises
    ------
    InputError
        If an effect or a route is unknown or an effect given twice, there is no record or they are of several kinds,
        or they do not carry such a fit.
    """
    _check_effects(effects)
    if route not in ROUTES:
        raise unknown_name("a route of a fit", route, ROUTES)
    check_one_kind(records)
    records = told_apart(records)
    if records[0].kind == "stem":
        if has_profile or repetitions:
            raise InputError(
                "profile and bootstrap are for records with current",
                f"{records[0].name} has force",
                "leave them out: a force balance is linear, and its intervals are those of a regression",
            )
        return _fit_stem_record(records, model, effects, progress)
    began = time.perf_counter()
    experiments, notes = experiments_of(records, is_ramped=is_ramped)
    _check_ramped(records, model, effects, is_ramped=is_ramped)
    if any(map(may_be_noisy, experiments)):
        experiments = as_set(experiments, fit_base(model, experiments))
        notes += said_of_current(experiments)
    if any(map(may_have_moved, experiments)):
        held, experiments = experiments, moving_between_rows(experiments, fit_base(model, experiments))
        notes = said_of_motion(notes, experiments, held)
    holdout = hold_out(experiments)
    smoothing: tuple[Smoothing, ...] = ()
    if route == "smooth":
        part, whole, smoothing = _fit_smoothly(holdout, experiments, model, effects, progress)
    else:
        part, whole = _fit_exactly(holdout, experiments, model, effects, progress)
    rms_unseen = rms_of(part, holdout.scored_experiments, holdout.scored)
    samples = None
    if has_profile and is_jagged(whole.model.effects):
        whole, samples = sampled(whole, progress)
    found = tuple(estimates(whole))
    account = account_of(
        whole,
        found,
        next(record for record in records if (record.pressure is not None) == whole.problem.has_pressure),
        has_profile=has_profile,
        samples=samples,
        repetitions=repetitions,
        progress=progress,
    )
    loop = shape_of_fit(whole)
    if loop is not None:
        notes.append(SAYS_NOTHING_OF_TIME)
    return Outcome(
        records=tuple(record.name for record in records),
        effects=tuple(effects),
        parameters=found,
        model=replace(whole.model, name=_fitted_name(model, records)),
        unit="m",
        rms_fitted=rms_of(whole, experiments, measured(experiments)),
        rms_unseen=rms_unseen,
        unseen=holdout.scored_on,
        noise=holdout.floor,
        starts={each.name: start for each, start in zip(experiments, whole.starts, strict=True)},
        open=account.open,
        warnings=(*(warning for record in records for warning in record.warnings), *notes),
        seconds=time.perf_counter() - began,
        determined=account,
        checks=residual_check(whole),
        route=route,
        smoothing=smoothing,
        loop=loop,
        residuals=residuals_of(whole),
    )


def _check_ramped(records: Sequence[Record], model: Model, effects: Sequence[str], *, is_ramped: bool) -> None:
    if not is_ramped:
        return
    if records[0].kind != "loop":
        raise InputError(
            "only a settled loop is stepped or ramped",
            f"{records[0].name} has a time column",
            "leave --loop out: the record shows how its current went",
        )
    if not {*model.effects, *effects} <= SETTLING_EFFECTS:
        raise InputError(
            f"a ramped loop is fitted with no effects but {', '.join(sorted(SETTLING_EFFECTS))}",
            f"got {', '.join(effects)}",
            "fit it as stepped, or leave the others out",
        )


def _fit_exactly(
    holdout: Holdout, experiments: Sequence[Experiment], model: Model, effects: Sequence[str], progress: Progress
) -> tuple[Fit, Fit]:
    """Return a fit to what is not kept back, and one to all."""
    fit = fit_exact(model, holdout.experiments, holdout.fitted, effects=effects, progress=progress)
    progress("all data", 1.0 - 1.0 / (len(effects) + 2))
    return fit, fitted_to_all(fit, experiments)


def _fit_smoothly(
    holdout: Holdout, experiments: Sequence[Experiment], model: Model, effects: Sequence[str], progress: Progress
) -> tuple[Fit, Fit, tuple[Smoothing, ...]]:
    """Return the same by the smooth route, and what smoothing did to the fit to all."""
    from identification.smooth_fit import fit_smooth

    part = fit_smooth(
        holdout.experiments, model, effects=effects, used=holdout.fitted,
        progress=lambda what, share: progress(what, 0.5 * share),
    )  # fmt: skip
    base = Model(model.name, part.fit.model.values, model.effects)
    whole = fit_smooth(
        experiments,
        base,
        effects=effects,
        progress=lambda what, share: progress(f"all data, {what}", 0.5 + 0.5 * share),
    )
    return part.fit, whole.fit, whole.smoothing


def _check_effects(effects: Sequence[str]) -> None:
    for number, key in enumerate(effects):
        effect_of_key(key)
        if key in effects[:number]:
            raise InputError("an effect is fitted once", f"{key} came twice", "name it once")


def _fitted_name(model: Model, records: Sequence[Record]) -> str:
    return f"{model.name} fitted to {', '.join(record.name for record in records)}"


def _fit_stem_record(records: Sequence[Record], model: Model, effects: Sequence[str], progress: Progress) -> Outcome:
    """Fit the stem alone, by its force balance, to one record of force and position."""
    from identification.inverse_dynamics import fit_stem, prepare_signals
    from identification.inverse_dynamics.fit import blocks_of, find_spring

    if len(records) > 1:
        raise InputError(
            "a fit of the stem alone takes one record",
            f"got {len(records)}",
            "fit them one by one and compare the parameters",
        )
    began = time.perf_counter()
    progress("force balance of the stem", 0.0)
    record = records[0]
    signals = prepare_signals(record)
    has_spring = find_spring(signals) or "spring_hardening" in effects
    block = blocks_of(signals)
    seen = block % EVERY != EVERY - 1
    part = fit_stem(signals, effects=effects, train=seen, has_spring=has_spring)
    progress("all data", 0.5)
    whole = fit_stem(signals, effects=effects, has_spring=has_spring)
    found = tuple(
        Estimate(name, each.value, each.unit, each.std, _is_at_bound(name, each.value, effects))
        for name, each in whole.parameters.items()
    )
    reasons = {each.name: AT_A_BOUND if each.is_at_bound else HARDLY_SEEN for each in found if each.std is None}
    others = [each.name for each in BASE_PARAMETERS if each.name not in {*whole.values, *_STEM_ALONE}]
    notes = [f"force and position alone say nothing of {', '.join(others)}: the model has those of {model.name}"]
    if not has_spring:
        notes.append("the force does not rise with the position: the model has no spring")
    fitted: Model | None = None
    try:
        fitted = _stem_model(model, record, whole.values, {key: list(own) for key, own in whole.by_effect().items()})
    except InputError as error:
        notes.append(f"no model.json: {error.rule}, and {error.arrived}")
    return Outcome(
        records=(record.name,),
        effects=tuple(effects),
        parameters=found,
        model=fitted,
        unit="N",
        rms_fitted=whole.rms,
        rms_unseen=part.held_out_rms,
        unseen="held-out blocks",
        noise=None,
        starts={},
        open=reasons,
        warnings=(*record.warnings, *notes),
        seconds=time.perf_counter() - began,
        determined=account_of_stem(record, model, found, reasons, blocks=len(np.unique(block))),
        residuals=(Residual(record.name, whole.time, whole.residual, "N"),),
    )


def _stem_model(model: Model, record: Record, values: dict[str, float], own: dict[str, list[str]]) -> Model:
    base = {each.name: values[each.name] for each in BASE_PARAMETERS if each.name in values}
    effects = {key: {name: values[name] for name in names} for key, names in own.items()}
    stem = {"spring_rate": 0.0, "spring_preload": 0.0, **base}
    return Model(_fitted_name(model, [record]), {**model.values, **stem}, {**model.effects, **effects})


def _is_at_bound(name: str, value: float, effects: Sequence[str]) -> bool:
    declared = [*BASE_PARAMETERS, *(each for key in effects for each in effect_of_key(key).parameters)]
    return any(each.name == name and not each.low < value < each.high for each in declared)
