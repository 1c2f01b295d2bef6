"""A fit reduced by one of its effects: what is left is fitted anew from where it is."""

from __future__ import annotations

from dataclasses import replace

from threadpoolctl import threadpool_limits

from identification.fit import Fit, finished
from identification.search import descend_to_end
from identification.unknowns import freed_by
from valvemodel.effects import effect_of_key


@threadpool_limits.wrap(limits=1)
def reduced(fit: Fit, key: str) -> Fit:
    """Take an effect out of a fit and fit all other unknowns anew, from their values beside it.

    Base parameters that it alone freed are again as they were given.
    An effect that is none may have led the others out of a side minimum.

    Raises
    ------
    KeyError
        If the fit has no such effect.
    """
    if key not in fit.model.effects:
        raise KeyError(f"no effect {key!r} in the fit, only {', '.join(fit.model.effects) or 'none'}")
    model = fit.model.without_effect(key)
    before, after = (freed_by(each.effects, with_pressure=fit.problem.has_pressure) for each in (fit.model, model))
    held = before - after
    taken = {each.name for each in effect_of_key(key).parameters} | held
    kept = [number for number, unknown in enumerate(fit.unknowns) if unknown.name not in taken]
    problem = replace(
        fit.problem,
        model=model.with_values(**{name: fit.problem.model.values[name] for name in held}),
        unknowns=[fit.unknowns[number] for number in kept],
    )
    return finished(problem, descend_to_end(problem, fit.found.point[kept]))
