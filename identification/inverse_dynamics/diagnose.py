"""Which effect a record of force and position calls for, scored on blocks of time that were not fitted."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from identification.inverse_dynamics.fit import (
    Balance,
    Shapes,
    StemFit,
    Terms,
    blocks_of,
    find_spring,
    root_mean_square,
    solve_normal,
)
from identification.inverse_dynamics.regressors import (
    EXACT_ALIASES,
    NOT_APPLICABLE,
    base_columns,
    stem_candidates,
    stem_effect,
)
from identification.inverse_dynamics.signals import (
    Array,
    Mask,
    StemSignals,
    prepare_signals,
)
from valvemodel.errors import InputError
from valvemodel.records.record import Record

FOLDS = 3
"""Every third block is held out, in turn."""

GUARD_ROWS = 3
"""Rows at either end of a block that are scored but not fitted: the decimation filter reaches over them."""

PARAMETER_PENALTY = 1.0
"""Log-likelihood that each further parameter has to earn beyond its held-out score."""

NOTICE_SHARE = 0.1
"""An effect that closes less than this share of the reducible gap, more than the best of its parts, is not
named."""

NOTICE_RMS = 0.01
"""Nor is one that lowers the held-out error by less than this share."""

DRAWS = 2000
SEED = 20210
CLEAR_DIFFERENCE = 2.0
"""In standard errors of the block-wise difference: below it two causes are not told apart."""

UNKNOWN_FROM, UNKNOWN_AT = 1.1, 1.3
"""Where no effect helps: a base error over the noise floor by these factors is `unknown` not at all, and
wholly."""

INTERVAL = (2.5, 97.5)


@dataclass(frozen=True)
class Gap:
    """The force error from the refitted base model to the noise floor. [N]

    Parameters
    ----------
    refitted, with_cause : float
        Root mean square on held-out blocks, of the base model and of the best cause.
    noise_floor : float
        From the second differences of the best cause's residual.
    gap_closed : float or None
        (refitted - with_cause) / (refitted - noise_floor); None where nothing is reducible.
    gap_closed_interval : (float, float) or None
        95 %, by bootstrap over blocks.
    scored_on : str
    unit : str
    """

    refitted: float
    with_cause: float
    noise_floor: float
    gap_closed: float | None
    gap_closed_interval: tuple[float, float] | None
    scored_on: str = "held-out blocks"
    unit: str = "N"


@dataclass(frozen=True, eq=False)
class ScoredCause:
    """One set of effects, fitted to the whole record and scored on what a fit had not seen.

    Parameters
    ----------
    effects : tuple of str
        Empty for `none`.
    probability : float
        Among all causes; `StemDiagnosis.unknown_probability` is the rest to 1.
    fit : StemFit
        On the whole record.
    gap_after : float
        Root mean square on held-out blocks. [N]
    gap_after_second_half : float
        The same on the second half, fitted on the first. [N]
    gap_closed, gap_closed_interval
        As in `Gap`.
    block_errors : array, shape (blocks,)
        Mean square on each held-out block. [N^2]
    parameter_count : int
        Beyond the base model.
    is_below_notice : bool
        Too small an effect to be named (`NOTICE_SHARE`, `NOTICE_RMS`), or out of bounds.
    indistinguishable_from : tuple of tuple of str
        Sets of effects within two standard errors of it; an empty one is the base model.
    """

    effects: tuple[str, ...]
    probability: float
    fit: StemFit
    gap_after: float
    gap_after_second_half: float
    gap_closed: float | None
    gap_closed_interval: tuple[float, float] | None
    block_errors: Array
    parameter_count: int
    is_below_notice: bool
    indistinguishable_from: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class StemDiagnosis:
    """What a record of force and position says about the stem.

    Parameters
    ----------
    verdict : "effect", "none" or "unknown"
    causes : tuple of ScoredCause
        The most probable first; base, each candidate, and pairs built on the best one.
    unknown_probability : float
    base : StemFit
    gap : Gap
    remaining_share : float
        Of the reducible gap that the best cause leaves open.
    has_spring : bool
        Whether the base model has one.
    aliases : dict of str
        Effects that are the base model in other words, and why.
    not_applicable : dict of str
        Effects of the stem that such a record cannot show, and why.
    signals : StemSignals
    stage : str
        Always "stem": nothing else is in the record.
    """

    verdict: str
    causes: tuple[ScoredCause, ...]
    unknown_probability: float
    base: StemFit
    gap: Gap
    remaining_share: float
    has_spring: bool
    aliases: dict[str, str]
    not_applicable: dict[str, str]
    signals: StemSignals
    stage: str = "stem"

    def cause(self, *effects: str) -> ScoredCause:
        """Return the scored cause with exactly these effects; none of them for the base model."""
        for cause in self.causes:
            if set(cause.effects) == set(effects):
                return cause
        raise InputError(
            "the cause is one that was scored",
            f"got {', '.join(effects) or 'none'}",
            "choose one of " + "; ".join(", ".join(each.effects) or "none" for each in self.causes),
        )


def diagnose_stem(record: Record | StemSignals) -> StemDiagnosis:
    """Find which effect the force balance of a stem lacks.

    Each candidate is fitted to two thirds of the record's blocks in time and scored on the last third, in
    turn; and fitted to the first half and scored on the second. Parameters that are not linear are searched
    inside each fit. Probabilities: a Gaussian log-likelihood per block, with samples counted by their
    autocorrelation time, less a penalty a parameter, averaged over Bayesian bootstrap weights of the blocks
    (pseudo-BMA+).

    Parameters
    ----------
    record : Record or StemSignals
        Time [s], force [N], position [m].

    Returns
    -------
    StemDiagnosis

    Raises
    ------
    InputError
        As `prepare_signals`.

    References
    ----------
    Yao, Vehtari, Simpson, Gelman, Bayesian Analysis 13 (2018), pseudo-BMA+ with the Bayesian bootstrap.
    """
    signals = record if isinstance(record, StemSignals) else prepare_signals(record)
    has_spring = find_spring(signals)
    scorer = _Scorer(signals, has_spring)
    keys = [key for key in stem_candidates(has_spring=has_spring) if key not in EXACT_ALIASES]
    scores: dict[tuple[str, ...], _Score] = {(): scorer.score(())}
    for key in keys:
        scores[(key,)] = scorer.score((key,))
    first = min((effects for effects in scores if effects), key=lambda effects: scores[effects].mean_square)
    for key in keys:
        if key != first[0]:
            scores[(*first, key)] = scorer.score((*first, key))
    return _judge(signals, scores, scorer, has_spring)


@dataclass(frozen=True, eq=False)
class _Score:
    """Held-out errors of one set of effects."""

    errors: Array
    """By row, from the fold that holds it out, shape (rows,). [N]"""
    block_errors: Array
    second_half: Array
    """Mean square by block of the first half's fit, NaN in the first half, shape (blocks,). [N^2]"""
    parameter_count: int

    @property
    def mean_square(self) -> float:
        return float(np.mean(self.errors**2))

    @property
    def block_scores(self) -> Array:
        """Mean square by block over the schemes that hold it out, shape (blocks,). [N^2]"""
        both = 0.5 * (self.block_errors + self.second_half)
        return np.where(np.isnan(self.second_half), self.block_errors, both)


class _Scorer:
    """Cross-validation by sums over blocks: each column's products are computed once for all candidates."""

    def __init__(self, signals: StemSignals, has_spring: bool) -> None:
        self.signals = signals
        self.has_spring = has_spring
        self.base = tuple(base_columns(signals, has_spring=has_spring))
        raw = [signals.decimate(column) for column in base_columns(signals, has_spring=has_spring).values()]
        self.index: dict[tuple[str, int], list[int]] = {}
        self.shapes: dict[str, tuple[dict[str, float], ...]] = {}
        for key in stem_candidates(has_spring=has_spring):
            effect = stem_effect(key)
            self.shapes[key] = effect.grid(signals)
            for number, shape in enumerate(self.shapes[key]):
                columns = [signals.decimate(column) for column in effect.columns(signals, shape).T]
                self.index[key, number] = list(range(len(raw), len(raw) + len(columns)))
                raw.extend(columns)
        self.table = np.column_stack([*raw, signals.row_force])
        blocks = blocks_of(signals)
        self.numbers, self.blocks = np.unique(blocks, return_inverse=True)
        self.counts = np.bincount(self.blocks)
        self.is_inner = self._inner_rows()
        self.grams = np.array([self._gram(block) for block in range(self.numbers.size)])
        ranks = np.arange(self.numbers.size)
        self.folds = [ranks % FOLDS == fold for fold in range(FOLDS)]
        self.is_late = ranks >= (ranks.size + 1) // 2

    def score(self, keys: tuple[str, ...], *, polish: bool = False) -> _Score:
        """Return the held-out errors of the base model with these effects.

        Their shapes are searched in the grids, and polished between the grid's points on request, on the
        fitted blocks alone.
        """
        balance = Balance(self.signals, keys, self.has_spring) if polish else None
        errors = np.empty(self.signals.rows)
        for held in self.folds:
            prediction = self._predict(keys, ~held, balance)
            rows = held[self.blocks]
            errors[rows] = (self.table[:, -1] - prediction)[rows]
        late = (self.table[:, -1] - self._predict(keys, ~self.is_late, balance)) ** 2
        second_half = np.bincount(self.blocks, weights=late) / self.counts
        effects = [stem_effect(key) for key in keys]
        return _Score(
            errors=errors,
            block_errors=np.bincount(self.blocks, weights=errors**2) / self.counts,
            second_half=np.where(self.is_late, second_half, np.nan),
            parameter_count=sum(len(effect.declaration.parameters) for effect in effects),
        )

    def _gram(self, block: int) -> Array:
        rows = self.is_inner & (self.blocks == block)
        return self.table[rows].T @ self.table[rows]

    def _inner_rows(self) -> Mask:
        """Return the rows that are not within the guard of a block's ends; all rows of a short block."""
        ends = np.cumsum(self.counts)
        starts = ends - self.counts
        place = np.arange(self.blocks.size)
        to_edge = np.minimum(place - starts[self.blocks], ends[self.blocks] - 1 - place)
        return (to_edge >= GUARD_ROWS) | (self.counts[self.blocks] <= 4 * GUARD_ROWS)

    def _predict(self, keys: tuple[str, ...], train: Mask, balance: Balance | None) -> Array:
        """Return the force over all rows of the fit to some blocks; an effect out of bounds there is left
        out."""
        gram = self.grams[train].sum(axis=0)
        best = self._best(keys, gram)
        if balance is not None and best is not None and any(best[0].values()):
            rows = train[self.blocks] & self.is_inner
            return self.table[:, -1] - balance.residual(balance.polish(best[0], rows), rows)
        while best is None and keys:
            keys = keys[:-1]
            best = self._best(keys, gram)
        columns, amplitudes = best[1:] if best is not None else self._base_solution(gram)
        return self.table[:, columns] @ amplitudes

    def shapes_of(self, keys: tuple[str, ...]) -> Shapes:
        """Return the shapes in the grids that fit the whole record best."""
        best = self._best(keys, self.grams.sum(axis=0))
        return best[0] if best is not None else {key: self.shapes[key][0] for key in keys}

    def _base_solution(self, gram: Array) -> tuple[list[int], Array]:
        columns = list(range(len(self.base)))
        return columns, solve_normal(gram[np.ix_(columns, columns)], gram[columns, -1])

    def _best(self, keys: tuple[str, ...], gram: Array) -> tuple[Shapes, list[int], Array] | None:
        """Return the shapes in the grids, the columns and amplitudes of least error.

        One effect after the other, and for several effects once more. None if all are out of bounds.
        """
        terms = Terms(self.base, tuple(stem_effect(key) for key in keys))
        best: tuple[Shapes, list[int], Array] | None = None
        choice, least = [0] * len(keys), math.inf
        for _, place in itertools.product(range(max(len(keys), 1)), range(max(len(keys), 1))):
            for number in range(len(self.shapes[keys[place]]) if keys else 1):
                trial = [*choice]
                if keys:
                    trial[place] = number
                columns = self._columns(keys, tuple(trial), terms)
                moment = gram[columns, -1]
                amplitudes = solve_normal(gram[np.ix_(columns, columns)], moment)
                square = float(gram[-1, -1] - amplitudes @ moment)
                shapes = {key: self.shapes[key][number] for key, number in zip(keys, trial, strict=True)}
                if square < least and terms.is_admissible(terms.split(amplitudes, shapes)):
                    best, least, choice = (shapes, columns, amplitudes), square, trial
        return best

    def _columns(self, keys: tuple[str, ...], choice: tuple[int, ...], terms: Terms) -> list[int]:
        own = {key: self.index[key, number] for key, number in zip(keys, choice, strict=True)}
        reshaped = {base: own[effect.key][0] for base, effect in terms.reshaped.items() if base}
        columns = [reshaped.get(name, self.base.index(name)) for name in terms.base]
        for effect in terms.effects:
            if not effect.reshapes:
                columns.extend(own[effect.key])
        return columns


def _judge(
    signals: StemSignals,
    scores: dict[tuple[str, ...], _Score],
    scorer: _Scorer,
    has_spring: bool,
) -> StemDiagnosis:
    everything = np.ones(signals.rows, dtype=bool)
    balances = {effects: Balance(signals, effects, has_spring) for effects in scores}
    shapes = {effects: scorer.shapes_of(effects) for effects in scores}
    fits = {effects: balances[effects].fit(shapes[effects], everything) for effects in scores}
    richest = min(scores, key=lambda effects: scores[effects].mean_square)
    named = _named(scores, fits, _noise_floor(fits[richest], signals, math.sqrt(scores[richest].mean_square)))
    for effects in named:
        scores[effects] = scorer.score(effects, polish=True)
        fits[effects] = balances[effects].fit(balances[effects].polish(shapes[effects], everything), everything)
    richest = min(named, key=lambda effects: scores[effects].mean_square)
    floor = _noise_floor(fits[richest], signals, math.sqrt(scores[richest].mean_square))
    named = _named(scores, fits, floor)
    time = _correlation_time(scores[min(named, key=lambda effects: scores[effects].mean_square)].errors)
    weights, evidence = _weights({effects: scores[effects] for effects in named}, scorer.counts, time)
    base_error = math.sqrt(scores[()].mean_square)
    excess = (base_error / floor - UNKNOWN_FROM) / (UNKNOWN_AT - UNKNOWN_FROM) if floor > 0.0 else 1.0
    unknown = weights[()] * min(max(excess, 0.0), 1.0)
    weights[()] -= unknown
    draws = _block_draws(scorer.counts.size)
    causes = []
    for effects, score in scores.items():
        closed, interval = _closed(scores[()], score, floor, scorer.counts, draws)
        causes.append(
            ScoredCause(
                effects=effects,
                probability=weights.get(effects, 0.0),
                fit=fits[effects],
                gap_after=math.sqrt(score.mean_square),
                gap_after_second_half=math.sqrt(_late_mean(score, scorer.counts)),
                gap_closed=closed,
                gap_closed_interval=interval,
                block_errors=score.block_errors,
                parameter_count=score.parameter_count,
                is_below_notice=effects not in named,
                indistinguishable_from=_rivals(effects, evidence),
            )
        )
    causes.sort(key=lambda cause: (-cause.probability, cause.is_below_notice, cause.gap_after))
    best = causes[0]
    reducible = base_error - floor
    return StemDiagnosis(
        verdict="unknown" if unknown > best.probability else ("effect" if best.effects else "none"),
        causes=tuple(causes),
        unknown_probability=unknown,
        base=fits[()],
        gap=Gap(
            refitted=base_error,
            with_cause=best.gap_after,
            noise_floor=floor,
            gap_closed=best.gap_closed,
            gap_closed_interval=best.gap_closed_interval,
        ),
        remaining_share=max(best.gap_after - floor, 0.0) / reducible if reducible > 0.0 else 0.0,
        has_spring=has_spring,
        aliases=dict(EXACT_ALIASES),
        not_applicable=_not_applicable(has_spring),
        signals=signals,
    )


def _named(
    scores: dict[tuple[str, ...], _Score], fits: dict[tuple[str, ...], StemFit], floor: float
) -> list[tuple[str, ...]]:
    """Return the sets that lower the error by enough beyond the best of their parts, the base model first."""
    error = {effects: math.sqrt(score.mean_square) for effects, score in scores.items()}
    least = max(NOTICE_SHARE * (error[()] - floor), NOTICE_RMS * error[()])
    found: list[tuple[str, ...]] = [()]
    for effects in scores:
        if not effects or not fits[effects].is_admissible:
            continue
        parts = [part for size in range(len(effects)) for part in itertools.combinations(effects, size)]
        if min(error[part] for part in parts if part in error) - error[effects] >= least:
            found.append(effects)
    return found


def _noise_floor(fit: StemFit, signals: StemSignals, ceiling: float) -> float:
    """Return the noise of the decimated force from second differences of a residual, at most the error. [N]

    Exact for white noise; what the model misses slowly drops out of second differences.
    """
    steps = np.diff(fit.time)
    is_whole = (steps[1:] < 1.5 * signals.row_interval) & (steps[:-1] < 1.5 * signals.row_interval)
    second = np.diff(fit.residual, 2)[is_whole]
    if second.size == 0:
        return ceiling
    return min(root_mean_square(second) / math.sqrt(6.0), ceiling)


def _correlation_time(errors: Array) -> float:
    """Return 1 + 2 (sum of autocorrelations up to the first pair that is not positive), at least 1.
    [samples]"""
    centred = errors - errors.mean()
    size = centred.size
    spectrum = np.abs(np.fft.rfft(centred, 2 * size)) ** 2
    correlation = np.fft.irfft(spectrum)[: size // 4]
    if correlation[0] <= 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    pairs = correlation[1:-1:2] + correlation[2::2][: correlation[1:-1:2].size]
    stop = int(np.argmax(pairs <= 0.0)) if (pairs <= 0.0).any() else pairs.size
    return max(1.0, 1.0 + 2.0 * float(pairs[:stop].sum()))


def _weights(
    scores: dict[tuple[str, ...], _Score], counts: npt.NDArray[np.int64], time: float
) -> tuple[dict[tuple[str, ...], float], dict[tuple[str, ...], Array]]:
    """Return each set's probability and its log-likelihood by block (its penalty spread over the blocks)."""
    names = list(scores)
    variance = min(float(np.average(score.block_scores, weights=counts)) for score in scores.values())
    variance = max(variance, np.finfo(float).tiny)
    evidence = {
        effects: -0.5 * counts / time * score.block_scores / variance
        - PARAMETER_PENALTY * score.parameter_count / counts.size
        for effects, score in scores.items()
    }
    table = np.array([evidence[effects] for effects in names])
    draws = np.random.default_rng(SEED).dirichlet(np.ones(counts.size), DRAWS) * counts.size
    totals = draws @ table.T
    shares = np.exp(totals - totals.max(axis=1, keepdims=True))
    shares /= shares.sum(axis=1, keepdims=True)
    return dict(zip(names, shares.mean(axis=0).tolist(), strict=True)), evidence


def _rivals(effects: tuple[str, ...], evidence: dict[tuple[str, ...], Array]) -> tuple[tuple[str, ...], ...]:
    """Return the named sets whose log-likelihood is not clearly another; exact aliases of the base model
    with it."""
    found: list[tuple[str, ...]] = []
    if effects in evidence:
        for rival, blocks in evidence.items():
            if rival == effects:
                continue
            difference = evidence[effects] - blocks
            error = math.sqrt(difference.size) * float(np.std(difference, ddof=1))
            if abs(float(difference.sum())) < max(CLEAR_DIFFERENCE * error, PARAMETER_PENALTY):
                found.append(rival)
    if not effects:
        found.extend((key,) for key in EXACT_ALIASES)
    return tuple(found)


def _block_draws(blocks: int) -> npt.NDArray[np.int64]:
    return np.random.default_rng(SEED + 1).integers(0, blocks, (DRAWS, blocks))


def _closed(
    base: _Score, score: _Score, floor: float, counts: npt.NDArray[np.int64], draws: npt.NDArray[np.int64]
) -> tuple[float | None, tuple[float, float] | None]:
    """Return the share of the reducible gap that is closed, and its 95 % interval over resampled blocks."""
    reducible = math.sqrt(base.mean_square) - floor
    if reducible <= NOTICE_RMS * floor:
        return None, None
    weights = counts[draws]
    before = np.sqrt((base.block_errors[draws] * weights).sum(axis=1) / weights.sum(axis=1))
    after = np.sqrt((score.block_errors[draws] * weights).sum(axis=1) / weights.sum(axis=1))
    is_open = before > floor
    shares = (before - after)[is_open] / (before - floor)[is_open]
    low, high = np.percentile(shares, INTERVAL) if shares.size else (0.0, 0.0)
    closed = (math.sqrt(base.mean_square) - math.sqrt(score.mean_square)) / reducible
    return closed, (float(low), float(high))


def _late_mean(score: _Score, counts: npt.NDArray[np.int64]) -> float:
    is_late = ~np.isnan(score.second_half)
    return float(np.average(score.second_half[is_late], weights=counts[is_late]))


def _not_applicable(has_spring: bool) -> dict[str, str]:
    reasons = dict(NOT_APPLICABLE)
    if not has_spring:
        reasons["spring_hardening"] = "the base model of this record has no spring"
    return reasons
