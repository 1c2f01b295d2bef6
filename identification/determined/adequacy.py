"""What a record lacks for a fit, and what to record next: raised where nothing can be fitted, else said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identification.experiment import Experiment
from identification.noise import noise_level
from valvemodel.errors import InputError
from valvemodel.records.unbroken import unbroken

MEANS = 100
"""A record is looked at through the means of so many parts."""

STILL = 7.0
"""Means of noise alone spread over less than this. [noise of a mean]"""

DROWNED, FAINT = 2.0, 20.0
"""Travel over noise below which nothing, and below which little, can be fitted."""

FEWEST_SAMPLES, FEWEST_PAIRS = 40, 10
"""Five samples for each number of a base fit; of a loop, three for each number that shows in it."""

MOST_PAIRS = 2000
"""Settled pairs of a loop at most: each takes as long to run as seconds of a record."""

AGAINST = -0.8
"""Correlation of position and current below which the stem falls where the model's rises, whatever else it does."""

TURN = 0.05
"""Share of the travel by which the stem has to come back to have turned."""

CLIPPED_RUN, CLIPPED_SHARE, MOST_CLIPPED = 5, 0.01, 0.5
"""A reading that stays at its extreme for so many samples is clipped, from this share of the record on; more than the
last share leaves too little."""

REPEATING = 0.3
"""Where more readings than this repeat elsewhere too, the transmitter is coarse, not clipped."""

NOISELESS = 1e-6
"""Share of the travel below which readings have no noise, so that a stop looks like clipping."""

NEXT = "drive the valve up and down twice through at least a quarter of its travel, and record that"

WIDER_RANGE = "set the transmitter's range wider than the travel and record again"

ONE_WAY = "the stem moves one way only"

MOVED_UNSEEN = (
    "how the current went on between the rows is not recorded, and how late it came is told by the same readings"
)


def adequate(experiments: Sequence[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Return the experiments without clipped readings, and what to record next where they say little.

    Raises
    ------
    InputError
        If none of them can be fitted: says what is missing and what to record.
    """
    kept, notes, refused = [], [], []
    for experiment in experiments:
        clean, said = without_clipped(experiment)
        try:
            check_clipping(experiment, clean)
            check(clean)
        except InputError as error:
            refused.append(error)
            said.append(f"{error.rule}; {error.arrived}: {error.remedy}")
        kept.append(clean)
        notes += said
    if len(refused) == len(experiments):
        raise refused[0]
    return kept, notes + _said_of_turns(kept) + _said_of_noise(kept)


def undetermined_by(experiments: Sequence[Experiment]) -> dict[str, str]:
    """Return the parameters that no fit of these experiments may give a confident number, with the reason."""
    lacking = {"coulomb_friction": ONE_WAY} if _most_turns(experiments) == 0 else {}
    if any(experiment.parts > 1 for experiment in experiments):
        lacking["viscous_friction"] = MOVED_UNSEEN
    return lacking


def check(experiment: Experiment) -> None:
    """Raise if nothing can be fitted to an experiment."""
    name, is_read = experiment.name, np.isfinite(experiment.position)
    readings = experiment.position[is_read]
    fewest, rows = (FEWEST_PAIRS, "pairs") if experiment.is_loop else (FEWEST_SAMPLES, "samples")
    if len(readings) < fewest:
        raise InputError(
            f"a fit takes at least {fewest} {rows} with a position",
            f"{name} has {len(readings)}",
            f"record for longer: {NEXT}",
        )
    if experiment.is_loop and len(readings) > MOST_PAIRS:
        raise InputError(
            f"a record without a time is a loop of at most {MOST_PAIRS} settled pairs",
            f"{name} has {len(readings)}",
            "give the time in a column such as 'time [s]', if the rows were recorded over time; of a loop keep a pair"
            " for each current",
        )
    if np.ptp(experiment.current) == 0.0:
        raise InputError("the current changes over a record", f"{name}: it is constant", NEXT)
    means, noise_of_mean = _means(experiment)
    travel = float(np.ptp(means))
    found = f"{name}: {1e3 * travel:.3g} mm of travel in {1e3 * experiment.noise:.3g} mm of noise"
    if travel <= STILL * noise_of_mean and not experiment.is_loop:
        raise InputError("the stem moves in a record", f"{found}, while the current changes", _beyond_dead_band())
    if travel < DROWNED * experiment.noise:
        raise InputError("the stem moves by more than the noise of its readings", found, _quieter())
    together = float(np.corrcoef(experiment.current[is_read], readings)[0, 1])
    if together < AGAINST:
        raise InputError(
            "the stem rises with the current",
            f"{name}: its position falls where the current rises (their correlation is {together:.2f})",
            "of a reverse-acting valve, count the position from the other end: the rated travel less the reading",
        )


def without_clipped(experiment: Experiment) -> tuple[Experiment, list[str]]:
    """Return an experiment with clipped readings taken out, and a sentence about them.

    Where they are most of it there is none: `check_clipping` says so.
    """
    is_clipped = clipped_readings(experiment)
    share = float(is_clipped.mean())
    if share < CLIPPED_SHARE:
        return experiment, []
    position = np.where(is_clipped, np.nan, experiment.position)
    clean = replace(experiment, position=position, noise=noise_level(position))
    if share > MOST_CLIPPED:
        return clean, []
    return clean, [f"{_clipped_words(experiment, share)}: they are clipped and left out; {WIDER_RANGE}"]


def check_clipping(experiment: Experiment, clean: Experiment) -> None:
    """Raise if most readings of an experiment are clipped, which one without these tells."""
    share = float((np.isfinite(experiment.position) & np.isnan(clean.position)).mean())
    if share > MOST_CLIPPED:
        found = _clipped_words(experiment, share)
        raise InputError("the position is not clipped over most of a record", found, WIDER_RANGE)


def clipped_readings(experiment: Experiment) -> np.ndarray:
    """Return which readings repeat an extreme exactly while others scatter, shape (n,): a stop would scatter too."""
    position = experiment.position
    clipped = np.zeros(len(position), bool)
    readings = position[np.isfinite(position)]
    if experiment.is_loop or len(readings) < FEWEST_SAMPLES:
        return clipped
    for extreme in (readings.max(), readings.min()):
        is_at = position == extreme
        for first, end in unbroken(is_at):
            clipped[first:end] |= end - first >= CLIPPED_RUN
    repeats = np.diff(position) == 0.0
    elsewhere = ~(clipped[1:] | clipped[:-1])
    is_coarse = not elsewhere.any() or float(repeats[elsewhere].mean()) > REPEATING
    is_smooth = noise_level(position[~clipped]) <= NOISELESS * np.ptp(readings)
    return np.zeros(len(position), bool) if is_coarse or is_smooth else clipped


def _clipped_words(experiment: Experiment, share: float) -> str:
    return f"{experiment.name}: {share:.0%} of the positions stay at the highest or lowest reading without noise"


def turns(experiment: Experiment) -> int:
    """Return how often the stem turns by more than a share of its travel and more than noise."""
    means, noise_of_mean = _means(experiment)
    band = max(TURN * float(np.ptp(means)), STILL * noise_of_mean)
    count, side, extreme = 0, 0, float(means[0])
    for mean in means:
        if side == 0 and abs(mean - extreme) > band:
            side, extreme = (1 if mean > extreme else -1), float(mean)
        elif side * (mean - extreme) > 0.0:
            extreme = float(mean)
        elif side * (extreme - mean) > band:
            count, side, extreme = count + 1, -side, float(mean)
    return count


def _means(experiment: Experiment) -> tuple[np.ndarray, float]:
    """Return the means of parts of the readings, and the noise of one mean. [m]"""
    readings = experiment.position[np.isfinite(experiment.position)]
    width = 1 if experiment.is_loop else max(len(readings) // MEANS, 1)
    means = readings[: width * (len(readings) // width)].reshape(-1, width).mean(axis=1)
    return means, experiment.noise / np.sqrt(width)


def _most_turns(experiments: Sequence[Experiment]) -> int:
    return sum(turns(experiment) for experiment in experiments)


def _said_of_turns(experiments: Sequence[Experiment]) -> list[str]:
    count = _most_turns(experiments)
    if count == 0:
        return [f"{ONE_WAY}: friction cannot be told from the spring's zero, and gets no standard deviation; {NEXT}"]
    if count == 1:
        return [f"the stem turns only once: one width of the loop, and nothing to check it against; {NEXT}"]
    return []


def _said_of_noise(experiments: Sequence[Experiment]) -> list[str]:
    faint = []
    for experiment in experiments:
        travel = float(np.ptp(_means(experiment)[0]))
        if travel < FAINT * experiment.noise:
            faint.append(f"{experiment.name}: the travel is only {travel / experiment.noise:.2g} times the noise; ")
    return [each + _quieter() for each in faint]


def _beyond_dead_band() -> str:
    return f"move the current by more than the dead band (some mA): {NEXT}"


def _quieter() -> str:
    return f"check the position transmitter, or move farther: {NEXT}"
