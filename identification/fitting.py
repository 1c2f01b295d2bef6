"""Fits of records: base valve and effects, to a part of the data and to all, and what comes of it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from identification.determined.account import account_of
from identification.determined.sampling import sampled
from identification.determined.uncertainty import estimates, rms_of
from identification.driving.between_rows import may_have_moved, moving_between_rows, said_of_motion
from identification.driving.measured_current import as_set, may_be_noisy, said_of_current
from identification.driving.timing import experiments_of
from identification.exact_fit import fit_exact
from identification.experiment import Experiment
from identification.fit import Fit, fit_base, fitted_to_all, measured
from identification.holdout import Holdout, hold_out
from identification.results.loop_shape import SAYS_NOTHING_OF_TIME, shape_of_fit
from identification.results.outcome import Outcome, fitted_name
from identification.results.residual import residuals_of
from identification.results.residual_check import residual_check
from identification.stem_fit import fit_stem_record
from valvemodel.effects import effect_of_key, is_jagged
from valvemodel.errors import InputError, unknown_name
from valvemodel.loops import SETTLING_EFFECTS
from valvemodel.model import Model
from valvemodel.progress import Progress, tell_nobody
from valvemodel.records import Record
from valvemodel.records.several import check_one_kind, told_apart

if TYPE_CHECKING:
    from identification.smooth_fit import Smoothing


def fit_records(
    records: Sequence[Record],
    model: Model,
    *,
    effects: Sequence[str] = (),
    is_ramped: bool = False,
    has_profile: bool = False,
    repetitions: int = 0,
    route: str = "exact",
    progress: Progress = tell_nobody,
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
        _check_stem(records, has_intervals=has_profile or bool(repetitions))
        return fit_stem_record(records, model, effects, progress)
    began = time.perf_counter()
    experiments, notes = experiments_of(records, is_ramped=is_ramped)
    _check_ramped(records, model, effects, is_ramped=is_ramped)
    experiments, notes = _driven(experiments, notes, model)
    holdout = hold_out(experiments)
    part, whole, smoothing = ROUTES[route](holdout, experiments, model, effects, progress)
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
        model=replace(whole.model, name=fitted_name(model, records)),
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


def _check_effects(effects: Sequence[str]) -> None:
    for number, key in enumerate(effects):
        effect_of_key(key)
        if key in effects[:number]:
            raise InputError("an effect is fitted once", f"{key} came twice", "name it once")


def _check_stem(records: Sequence[Record], *, has_intervals: bool) -> None:
    if has_intervals:
        raise InputError(
            "profile and bootstrap are for records with current",
            f"{records[0].name} has force",
            "leave them out: a force balance is linear, and its intervals are those of a regression",
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


def _driven(experiments: list[Experiment], notes: list[str], model: Model) -> tuple[list[Experiment], list[str]]:
    """Return experiments driven as their currents were set and moved between the rows, and what is said of them."""
    if any(map(may_be_noisy, experiments)):
        experiments = as_set(experiments, fit_base(model, experiments))
        notes = [*notes, *said_of_current(experiments)]
    if any(map(may_have_moved, experiments)):
        held, experiments = experiments, moving_between_rows(experiments, fit_base(model, experiments))
        notes = said_of_motion(notes, experiments, held)
    return experiments, notes


def _fit_exactly(
    holdout: Holdout, experiments: Sequence[Experiment], model: Model, effects: Sequence[str], progress: Progress
) -> tuple[Fit, Fit, tuple[Smoothing, ...]]:
    """Return a fit to what is not kept back, one to all, and that nothing was smoothed."""
    fit = fit_exact(model, holdout.experiments, holdout.fitted, effects=effects, progress=progress)
    progress("all data", 1.0 - 1.0 / (len(effects) + 2))
    return fit, fitted_to_all(fit, experiments), ()


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


ROUTES = {"exact": _fit_exactly, "smooth": _fit_smoothly}
"""How a fit is searched for, by the name of the route."""
