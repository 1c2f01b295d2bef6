"""The fit of a stem alone: its force balance, to one record of force and position."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from identification.determined.account import account_of_stem
from identification.determined.uncertainty import AT_A_BOUND, HARDLY_SEEN, Estimate
from identification.holdout import EVERY
from identification.results.outcome import Outcome, fitted_name
from identification.results.residual import Residual
from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.effects import effect_of_key
from valvemodel.errors import InputError
from valvemodel.model import Model
from valvemodel.progress import Progress
from valvemodel.records import Record

_STEM_ALONE = ("spring_rate", "spring_preload", "travel_min", "travel_max", "rated_travel")
"""Base parameters that a force balance settles or does not need, fitted or not."""


def fit_stem_record(records: Sequence[Record], model: Model, effects: Sequence[str], progress: Progress) -> Outcome:
    """Fit the stem alone, by its force balance, to one record of force and position.

    Raises
    ------
    InputError
        If there are several records, or the one does not carry such a fit.
    """
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
    return Model(fitted_name(model, [record]), {**model.values, **stem}, {**model.effects, **effects})


def _is_at_bound(name: str, value: float, effects: Sequence[str]) -> bool:
    declared = [*BASE_PARAMETERS, *(each for key in effects for each in effect_of_key(key).parameters)]
    return any(each.name == name and not each.low < value < each.high for each in declared)
