"""The search for causes, from a valve's experiments to all that was tried on them."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

from diagnosis.choosing.alone import in_phase, library_for, try_first
from diagnosis.choosing.selection import try_together
from diagnosis.choosing.stairs import on_stairs, stairs_beside
from diagnosis.score import score_fit
from diagnosis.trying.candidates import Candidate, scored
from diagnosis.trying.explaining import AT_NOISE, explains, misfit
from diagnosis.trying.parts import evenly_parted, parted
from diagnosis.trying.standing import NEAR_THE_BEST, best_of, with_better
from diagnosis.trying.unrecorded import largest_error, with_unrecorded
from diagnosis.trying.workshop import Workshop
from identification.driving.between_rows import followed_anew, moving_between_rows
from identification.driving.measured_current import as_set
from identification.experiment import Experiment
from identification.fit import Fit, fit_base, fitted_to_all
from identification.holdout import Holdout, hold_out
from valvemodel.declarations import Effect
from valvemodel.effects import effect_of_key
from valvemodel.model import Model
from valvemodel.progress import Progress


@dataclass(frozen=True)
class Searched:
    """What was tried on experiments, the base first.

    Attributes
    ----------
    experiments : list of Experiment
        As they were fitted and scored.
    holdout : Holdout
    base : Fit
        Of the base valve to what was not kept back.
    tried : list of Candidate
    library : sequence of Effect
        What could be tried.
    sampling_error : float [m]
        What counts as noise because a record does not have it of its current.
    notes : tuple of str
        What is said of that.
    """

    experiments: list[Experiment]
    holdout: Holdout
    base: Fit
    tried: list[Candidate]
    library: Sequence[Effect]
    sampling_error: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Search:
    """How causes are searched for: the valve as given, what may be tried, processes, and who is told."""

    model: Model
    candidates: Sequence[str] | None
    pool: Executor | None
    progress: Progress

    def on(self, held: Sequence[Experiment]) -> Searched:
        """Search for the causes of experiments whose currents are held from row to row, or move on as far as they tell.

        How a current moved on between the rows is known as well as the valve is: where the nearest cause tells it
        otherwise than the base did, all is tried once more. In stairs, which run out of phase, it tells nothing of it.
        """
        holdout = hold_out(held)
        library = library_for(holdout, self.candidates)
        self.progress("refitting the base valve", 0.0)
        base = fit_base(self.model, holdout.experiments, holdout.fitted)
        measured, held = held, as_set(held, base)
        if held != measured:
            holdout, base = parted(held, self.model)
        experiments = moving_between_rows(held, base)
        if all(each.parts == 1 for each in experiments):
            return self._tried_on(experiments, holdout, base, library)
        found = self._tried_on(experiments, *parted(experiments, self.model), library)
        nearest = min(found.tried, key=misfit)
        if misfit(nearest) < AT_NOISE or any(each.has_stairs for each in found.experiments):
            return found
        anew = followed_anew(experiments, held, nearest.fit)
        if anew == experiments:
            return found
        return self._tried_on(anew, *parted(anew, self.model), library)

    def _tried_on(
        self, as_read: Sequence[Experiment], holdout: Holdout, base: Fit, library: Sequence[Effect]
    ) -> Searched:
        model = self.model
        experiments, said = with_unrecorded(as_read, base)
        sampling_error = largest_error(experiments, as_read)
        if experiments != as_read:
            holdout, base = parted(experiments, model)
        holdout, base = evenly_parted(holdout, base, model)
        workshop = Workshop(holdout, self.pool, self.progress)
        experiments, holdout, base = on_stairs(experiments, workshop, base, library, model)
        workshop = replace(workshop, holdout=holdout)
        tried, together = try_first(of_no_effect(base, holdout), workshop, library)
        seen = stairs_beside(tried, experiments, holdout, model)
        for further in (in_phase, partial(try_together, together=together)):
            if not seen:
                tried = further(tried, workshop)
                seen = stairs_beside(tried, experiments, holdout, model)
        if seen:
            experiments, holdout, base = seen
            workshop = replace(workshop, holdout=holdout)
            tried, together = try_first_again(tried, of_no_effect(base, holdout), workshop, library)
            for further in (in_phase, partial(try_together, together=together)):
                tried = further(tried, workshop)
        return Searched(list(experiments), holdout, base, tried, library, sampling_error, tuple(said))


def of_no_effect(base: Fit, holdout: Holdout) -> Candidate:
    """Score the base valve as the cause that is none."""
    return Candidate((), base, score_fit(base, holdout))


def try_first_again(
    tried: Sequence[Candidate], base: Candidate, workshop: Workshop, library: Sequence[Effect]
) -> tuple[list[Candidate], list[Candidate] | None]:
    """Try what is tried first once more, beside the two effects beside which stairs showed, fitted as these count.

    With them come the pairs that were near, and each effect alone that took a global search: where the two explain the
    record none is searched again, but a law in closed form in place of one of more numbers.

    Parameters
    ----------
    tried : sequence of Candidate
        All that was tried on the record as it was.
    base : Candidate
        As the record counts now.
    workshop : Workshop
        With the holdout of that.
    library : sequence of Effect
    """
    pairs = best_of(tried, 2)
    near = [each for each in pairs if misfit(each) < NEAR_THE_BEST * misfit(pairs[0])]
    searched = [each for each in best_of(tried, 1) if effect_of_key(each.effects[0]).is_jagged]
    again = list(workshop.map(partial(fitted_again, holdout=workshop.holdout), [*near, *searched]))
    if explains(again[0], base):
        return try_first(base, workshop, library, again)
    first, together = try_first(base, workshop, library)
    return with_better(first, again), together


def fitted_again(cause: Candidate, holdout: Holdout) -> Candidate:
    """Fit the numbers of a cause once more, to the parts of other experiments, and score it."""
    return scored(cause.effects, fitted_to_all(cause.fit, holdout.experiments, holdout.fitted), holdout)
