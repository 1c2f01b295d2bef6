"""Least squares of the stem's force balance on prepared signals."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from identification.inverse_dynamics.regressors import (
    Estimate,
    StemEffect,
    Values,
    base_columns,
    stem_effect,
    unit_of,
)
from identification.inverse_dynamics.signals import (
    Array,
    Mask,
    StemSignals,
    prepare_signals,
)
from valvemodel.errors import InputError
from valvemodel.records.record import Record

BLOCK_DURATION = 1.0
"""Rows nearer than this may have correlated errors. [s]"""

FEWEST_BLOCKS, MOST_BLOCKS = 12, 60
NEGLIGIBLE_SINGULAR_VALUE = 1e-6
"""Of the scaled regressors: a direction below this share of the largest is not determined."""

RIDGE = 1e-12
"""Added to the scaled normal equations in searches: far below any effect, enough to keep a column of zeros
at 0."""

SPRING_SHARE = 0.1
"""A spring is taken into the base model unasked where its force varies by this share of the measured one."""

Shapes = dict[str, dict[str, float]]


@dataclass(frozen=True, eq=False)
class StemFit:
    """Parameters of a force balance, and what it leaves over.

    Parameters
    ----------
    effects : tuple of str
        Beyond the base model.
    parameters : dict of Estimate
        By the library's names: value, unit, standard deviation (None where not determined). The
        deviations are those of a jackknife over blocks in time of about 1 s, so that autocorrelation
        is counted.
    regressors : tuple of str
        What each column of `design` belongs to.
    design : array, shape (rows, columns)
    time : array, shape (rows,)
        Since the start of the record. [s]
    force, residual : array, shape (rows,)
        Decimated force, and measured less modelled. [N]
    rms, held_out_rms : float, float or None
        Of the residual on the fitted rows and on the others. [N]
    relative_error : float
        100 |residual| / |force| over all rows. [%]
    is_admissible : bool
        Whether the effects' parameters are within the bounds of their declarations.
    """

    effects: tuple[str, ...]
    parameters: dict[str, Estimate]
    regressors: tuple[str, ...]
    design: Array
    time: Array
    force: Array
    residual: Array
    rms: float
    held_out_rms: float | None
    relative_error: float
    is_admissible: bool

    @property
    def values(self) -> dict[str, float]:
        """The parameters' values alone."""
        return {name: estimate.value for name, estimate in self.parameters.items()}

    def by_effect(self) -> dict[str, dict[str, Estimate]]:
        """Return the effects' own parameters, by effect."""
        return {
            key: {
                each.name: self.parameters[each.name]
                for each in stem_effect(key).declaration.parameters
                if each.name in self.parameters
            }
            for key in self.effects
        }


def fit_stem(
    record: Record | StemSignals,
    *,
    effects: Iterable[str] = (),
    train: npt.ArrayLike | None = None,
    has_spring: bool | None = None,
) -> StemFit:
    """Fit the stem's force balance to a record of force and position.

    .. math:: F = m a + f_v v + F_c \\,\\mathrm{sign}(v) + F_0 + k y + \\ldots

    Positive along the position. Force and every regressor pass the same zero-phase low-pass and decimation,
    sign(v) is taken at the full rate before it: a sample around a reversal holds the share of time spent on
    either side. Where the speed is within its noise sign(v) is 0, and samples with more than 5 % of such
    rest are left out. Effects add up to first order: products of two effects' excesses are neglected.

    Parameters
    ----------
    record : Record or StemSignals
        Time [s], force [N], position [m].
    effects : iterable of str
        Keys out of `stem_candidates`.
    train : bool array, shape (rows,), optional
        The decimated samples to fit; all by default. `prepare_signals(record).rows` tells how many there are.
    has_spring : bool, optional
        Whether the base model has a spring; None lets the record decide (see `find_spring`).

    Returns
    -------
    StemFit
        `spring_preload` is the constant force F_0; times count from the start of the record.

    Raises
    ------
    InputError
        As `prepare_signals`; if an effect is unknown or the mask does not fit.

    References
    ----------
    EMPS benchmark, inverse dynamic identification model with least squares (IDIM-LS).
    """
    signals = record if isinstance(record, StemSignals) else prepare_signals(record)
    if has_spring is None:
        has_spring = find_spring(signals)
    chosen = tuple(dict.fromkeys(effects))
    for key in chosen:
        stem_effect(key)
    if "spring_hardening" in chosen and not has_spring:
        raise InputError(
            "a spring that hardens takes a spring",
            "the base model of this record has none",
            "pass has_spring=True or leave spring_hardening out",
        )
    rows = _train_rows(train, signals.rows)
    balance = Balance(signals, chosen, has_spring)
    return balance.fit(balance.polish(balance.search(rows), rows), rows)


def find_spring(signals: StemSignals) -> bool:
    """Return whether the force rises with the position by a share worth a spring in the base model.

    The spring rate must be positive by three standard deviations, and its force vary (standard deviation)
    by at least a tenth of the measured force. A weaker trend is not called a spring.
    """
    everything = np.ones(signals.rows, dtype=bool)
    rate = Balance(signals, (), True).fit({}, everything).parameters["spring_rate"]
    swing = rate.value * float(np.std(signals.position))
    return (
        rate.std is not None and rate.value > 3.0 * rate.std and swing > SPRING_SHARE * float(np.std(signals.row_force))
    )


def blocks_of(signals: StemSignals) -> npt.NDArray[np.int64]:
    """Return to which block in time each decimated sample belongs, shape (rows,); about 1 s, 12 to 60
    blocks."""
    time = signals.row_time
    duration = float(signals.time[-1] - signals.time[0])
    count = int(min(max(round(duration / BLOCK_DURATION), FEWEST_BLOCKS), MOST_BLOCKS))
    return np.minimum((time - signals.time[0]) * count // duration, count - 1).astype(np.int64)


def solve_normal(gram: Array, moment: Array) -> Array:
    """Solve the normal equations with scaled columns; undetermined directions get the smallest solution."""
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    scaled = gram / np.outer(scale, scale)
    return np.linalg.solve(scaled + RIDGE * np.eye(scale.size), moment / scale) / scale


class Terms:
    """Which columns a model has: the base model's and its effects', for given shapes."""

    def __init__(self, base: tuple[str, ...], effects: tuple[StemEffect, ...]) -> None:
        held = {effect.holds for effect in effects}
        self.effects = effects
        self.base = tuple(name for name in base if name not in held)
        self.all_base = base
        self.reshaped = {effect.reshapes: effect for effect in effects if effect.reshapes}

    def split(self, amplitudes: Array, shapes: Shapes) -> dict[str, float]:
        """Return the library's parameters of all amplitudes, in the order of the columns."""
        base = dict.fromkeys(self.all_base, 0.0)
        base.update(zip(self.base, (float(value) for value in amplitudes), strict=False))
        found = dict(base)
        start = len(self.base)
        for effect in self.effects:
            width = 0 if effect.reshapes else (2 if effect.key == "load_force" else 1)
            own = amplitudes[start : start + width]
            found.update(effect.parameters(own, base, shapes.get(effect.key, {})))
            start += width
        return found

    def is_admissible(self, parameters: Values) -> bool:
        """Return whether friction and mass are not negative and every effect is within its bounds."""
        friction = parameters["coulomb_friction"] >= 0.0
        return friction and all(effect.is_admissible(parameters) for effect in self.effects)


class Balance:
    """A force balance with chosen effects over prepared signals."""

    def __init__(self, signals: StemSignals, keys: tuple[str, ...], has_spring: bool) -> None:
        self.signals = signals
        self.keys = keys
        raw = base_columns(signals, has_spring=has_spring)
        self.base = {name: signals.decimate(column) for name, column in raw.items()}
        self.terms = Terms(tuple(raw), tuple(stem_effect(key) for key in keys))
        self.blocks = blocks_of(signals)
        self._kept: dict[str, tuple[tuple[float, ...], Array]] = {}

    def design(self, shapes: Shapes) -> tuple[Array, tuple[str, ...]]:
        """Return the decimated columns of the model and what they belong to."""
        columns = {name: self.base[name][:, None] for name in self.terms.base}
        for effect in self.terms.effects:
            raw = self._columns(effect, shapes.get(effect.key, {}))
            columns[effect.reshapes or effect.key] = raw
        owners = tuple(name for name, block in columns.items() for _ in range(block.shape[1]))
        return np.column_stack(list(columns.values())), owners

    def _columns(self, effect: StemEffect, shape: Values) -> Array:
        """Return the decimated columns of an effect; the last one's are kept, for a search moves one at a
        time."""
        numbers = tuple(shape.values())
        kept = self._kept.get(effect.key)
        if kept is None or kept[0] != numbers:
            raw = effect.columns(self.signals, shape)
            kept = numbers, np.column_stack([self.signals.decimate(column) for column in raw.T])
            self._kept[effect.key] = kept
        return kept[1]

    def residual(self, shapes: Shapes, rows: Mask) -> Array:
        """Return measured less modelled force over all rows, fitted to some of them, shape (rows,). [N]"""
        design, _ = self.design(shapes)
        return self.signals.row_force - design @ _least_squares(design[rows], self.signals.row_force[rows])

    def error(self, shapes: Shapes, rows: Mask) -> float:
        """Return the mean square on the fitted rows, infinite where the parameters are out of bounds.
        [N^2]"""
        design, _ = self.design(shapes)
        fitted, force = design[rows], self.signals.row_force[rows]
        amplitudes = solve_normal(fitted.T @ fitted, fitted.T @ force)
        if not self.terms.is_admissible(self.terms.split(amplitudes, shapes)):
            return math.inf
        return float(np.mean((force - fitted @ amplitudes) ** 2))

    def search(self, rows: Mask) -> Shapes:
        """Return the shapes of least error in the grids, one effect after the other, twice."""
        grids = {effect.key: effect.grid(self.signals) for effect in self.terms.effects}
        shapes: Shapes = {key: dict(grid[0]) for key, grid in grids.items()}
        free = [key for key, grid in grids.items() if grid[0]]
        for _, key in itertools.product(range(2 if len(free) > 1 else 1), free):
            trials = [{**shapes, key: dict(shape)} for shape in grids[key]]
            shapes = min(trials, key=lambda trial: self.error(trial, rows))
        return shapes

    def polish(self, shapes: Shapes, rows: Mask) -> Shapes:
        """Return the shapes of least error near given ones, by a simplex."""
        from scipy.optimize import minimize

        free = [key for key, shape in shapes.items() if shape]
        if not free or not math.isfinite(self.error(shapes, rows)):
            return shapes
        names = [(key, name) for key in free for name in shapes[key]]
        travel = float(np.ptp(self.signals.position))

        def unpack(numbers: Array) -> Shapes:
            moved = {key: dict(shape) for key, shape in shapes.items()}
            for (key, name), number in zip(names, numbers, strict=True):
                start = shapes[key][name]
                is_place = name == "tight_spot_position"
                moved[key][name] = start + 0.1 * travel * number if is_place else start * math.exp(0.3 * number)
            return moved

        scale = self.error(shapes, rows) or 1.0
        found = minimize(
            lambda numbers: min(self.error(unpack(numbers), rows) / scale, 1e6),
            np.zeros(len(names)),
            method="Nelder-Mead",
            bounds=[(-5.0, 5.0)] * len(names),
            options={
                "maxfev": 40 * len(names),
                "xatol": 3e-3,
                "fatol": 1e-6,
                "initial_simplex": _simplex(len(names)),
            },
        )
        return unpack(found.x) if found.fun < 1.0 else shapes

    def fit(self, shapes: Shapes, rows: Mask) -> StemFit:
        """Return the fit for given shapes."""
        design, owners = self.design(shapes)
        force = self.signals.row_force
        amplitudes = _least_squares(design[rows], force[rows])
        residual = force - design @ amplitudes
        values = self.terms.split(amplitudes, shapes)
        deviations = self._deviations(shapes, amplitudes, design, residual, rows)
        held_out = residual[~rows]
        return StemFit(
            effects=self.keys,
            parameters={name: Estimate(values[name], unit_of(name), deviations[name]) for name in values},
            regressors=owners,
            design=design,
            time=self.signals.row_time,
            force=force,
            residual=residual,
            rms=root_mean_square(residual[rows]),
            held_out_rms=root_mean_square(held_out) if held_out.size else None,
            relative_error=100.0 * float(np.linalg.norm(residual) / np.linalg.norm(force)),
            is_admissible=self.terms.is_admissible(values),
        )

    def _deviations(
        self, shapes: Shapes, amplitudes: Array, design: Array, residual: Array, rows: Mask
    ) -> dict[str, float | None]:
        """Return the standard deviation of each parameter: block jackknife, then the delta method."""
        names = [(key, name) for key, shape in shapes.items() for name in shape]
        slopes = [self._slope(shapes, key, name, amplitudes) for key, name in names]
        jacobian = np.column_stack([design, *slopes])[rows]
        scale = np.linalg.norm(jacobian, axis=0)
        scale[scale == 0.0] = 1.0
        _, singular, right = np.linalg.svd(jacobian / scale, full_matrices=False)
        is_known = singular > NEGLIGIBLE_SINGULAR_VALUE * singular[0]
        covariance = _jackknife(jacobian / scale, residual[rows], self.blocks[rows]) / np.outer(scale, scale)
        unknown = (np.abs(right[~is_known]) > 1e-3).any(axis=0) | (np.abs(jacobian).max(axis=0) == 0.0)
        centre = np.concatenate([amplitudes, [shapes[key][name] for key, name in names]])

        def parameters(numbers: Array) -> dict[str, float]:
            moved = {key: dict(shape) for key, shape in shapes.items()}
            for (key, name), number in zip(names, numbers[amplitudes.size :], strict=True):
                moved[key][name] = float(number)
            return self.terms.split(numbers[: amplitudes.size], moved)

        middle = parameters(centre)
        gradient = {name: np.zeros(centre.size) for name in middle}
        for column in range(centre.size):
            step = 1e-6 * (abs(centre[column]) or 1.0)
            shifted = centre.copy()
            shifted[column] += step
            for name, value in parameters(shifted).items():
                gradient[name][column] = (value - middle[name]) / step
        found: dict[str, float | None] = {}
        for name, slope in gradient.items():
            variance = float(slope @ covariance @ slope)
            is_determined = slope.any() and not (unknown & (slope != 0.0)).any() and math.isfinite(variance)
            found[name] = math.sqrt(max(variance, 0.0)) if is_determined else None
        return found

    def _slope(self, shapes: Shapes, key: str, name: str, amplitudes: Array) -> Array:
        """Return the derivative of the modelled force by a shape parameter."""
        value = shapes[key][name]
        step = 1e-3 * (shapes[key].get("tight_spot_width", value) if name == "tight_spot_position" else value)
        ends = [self.design({**shapes, key: {**shapes[key], name: value + sign * step}})[0] for sign in (1.0, -1.0)]
        return (ends[0] - ends[1]) @ amplitudes / (2.0 * step)


def root_mean_square(values: Array) -> float:
    """Return the root of the mean square."""
    return math.sqrt(float(np.mean(values**2)))


def nominal_residual(signals: StemSignals, nominal: Mapping[str, float]) -> Array:
    """Return measured force less the one of given base parameters, shape (rows,); absent parameters are 0.
    [N]"""
    columns = base_columns(signals, has_spring=True)
    modelled = sum(nominal.get(name, 0.0) * signals.decimate(column) for name, column in columns.items())
    return signals.row_force - modelled


def _least_squares(design: Array, force: Array) -> Array:
    scale = np.linalg.norm(design, axis=0)
    scale[scale == 0.0] = 1.0
    return np.linalg.lstsq(design / scale, force, rcond=NEGLIGIBLE_SINGULAR_VALUE)[0] / scale


def _jackknife(jacobian: Array, residual: Array, blocks: npt.NDArray[np.int64]) -> Array:
    """Return the covariance of a linear fit by leaving out one block after the other."""
    everything = jacobian.T @ jacobian
    shifts = []
    for block in np.unique(blocks):
        own, left = jacobian[blocks == block], residual[blocks == block]
        shifts.append(solve_normal(everything - own.T @ own, own.T @ left))
    moved = np.array(shifts)
    return moved.T @ moved * (len(shifts) - 1) / len(shifts)


def _simplex(size: int) -> Array:
    return np.vstack([np.zeros(size), np.eye(size)])


def _train_rows(train: npt.ArrayLike | None, rows: int) -> Mask:
    if train is None:
        return np.ones(rows, dtype=bool)
    mask = np.asarray(train)
    if mask.shape != (rows,) or mask.dtype != bool:
        raise InputError(
            "the mask has one truth value for each decimated sample",
            f"got {mask.dtype} of shape {mask.shape} for {rows} samples",
            "make it of the length prepare_signals(record).rows",
        )
    if mask.sum() < FEWEST_BLOCKS:
        raise InputError(f"a fit takes at least {FEWEST_BLOCKS} samples", f"the mask keeps {mask.sum()}", "keep more")
    return mask
