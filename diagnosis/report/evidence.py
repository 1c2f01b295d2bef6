"""The data behind the pictures: what was measured, what each model says, how the candidates compare."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RISING, STUCK, FALLING = 1, 0, -1
"""The values of `RecordEvidence.mode`."""


@dataclass(frozen=True, eq=False)
class RecordEvidence:
    """One record beside what the models say of it, in SI units; every array has shape (n,).

    `measured`, `as_given`, `refitted` and `with_cause` are the signal that the gap is measured in, in the
    unit of the `Evidence`: the position [m], or the force [N] for a record of the stem alone. A model that
    there is not (no cause, no valve given) is None. A missing sample is NaN.

    Parameters
    ----------
    name : str
        Name of the record, as the user knows it.
    time : array
        Time; equal steps are not needed. [s]
    current : array or None
        Current, the abscissa of the loop; None for a record of the stem alone. [A]
    measured, as_given, refitted, with_cause : array
        The signal: measured, of the valve as given, the refitted base, the base with cause. [m] or [N]
    held_out : array of bool
        Where the samples were kept out of the fits; the scores come from these.
    mode : array of int
        1 while the stem rises, 0 while it is stuck, -1 while it falls.
    measured_pressure, refitted_pressure, with_cause_pressure : array or None
        Actuator pressure, gauge, where it was measured. [Pa]
    position : array or None
        Position, the abscissa of a force's loop. [m]
    """

    name: str
    time: np.ndarray
    current: np.ndarray | None
    measured: np.ndarray
    as_given: np.ndarray | None
    refitted: np.ndarray
    with_cause: np.ndarray | None
    held_out: np.ndarray
    mode: np.ndarray
    measured_pressure: np.ndarray | None = None
    refitted_pressure: np.ndarray | None = None
    with_cause_pressure: np.ndarray | None = None
    position: np.ndarray | None = None

    def __post_init__(self) -> None:
        shape = np.shape(self.time)
        assert len(shape) == 1, f"{self.name}: time has shape {shape}"
        assert shape[0] > 1, f"{self.name}: a record has more than one sample"
        for field, values in vars(self).items():
            if field != "name" and values is not None:
                array = np.asarray(values)
                assert array.shape == shape, f"{self.name}: {field} has shape {array.shape}, time {shape}"
                object.__setattr__(self, field, array)


@dataclass(frozen=True)
class Step:
    """One bar of the gap shrinking: as given, base refitted, one for each effect added, noise floor."""

    label: str
    rms: float


@dataclass(frozen=True)
class Rank:
    """One candidate: its rms on unseen data with a 95 % interval, its probability; no effects: `none`."""

    label: str
    effects: tuple[str, ...]
    rms: float
    low: float
    high: float
    probability: float


@dataclass(frozen=True, eq=False)
class Evidence:
    """All that the pictures of one report show.

    `steps` go from the valve as given to the noise floor, `ranking` from the best candidate down; both, and
    `noise_floor`, are in `unit`: "m" or "N". `next_input` is time [s] and current [A] of the experiment that would
    tell rival causes apart, if one was designed.
    """

    records: tuple[RecordEvidence, ...]
    steps: tuple[Step, ...]
    ranking: tuple[Rank, ...]
    noise_floor: float | None
    unit: str
    seconds: float | None
    valve_name: str
    warnings: tuple[str, ...] = ()
    next_input: tuple[np.ndarray, np.ndarray] | None = None
