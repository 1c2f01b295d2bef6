"""The gap shows where it is fitted: which blocks in time are kept back."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.trying.parts import evenly_parted, gaps_of_blocks
from identification.fit import fit_base
from identification.holdout import EVERY, hold_out


def with_gap(experiment, sizes):
    """Return an experiment whose readings are off by so many times the noise in every so many blocks in time."""
    off = np.array(sizes)[experiment.block % EVERY] * np.sign(np.sin(20.0 * experiment.time))
    return replace(experiment, position=experiment.position + experiment.noise * off)


@pytest.mark.parametrize(
    ("sizes", "kept"),
    [
        ((0.0, 0.0, 30.0), (0, 1)),
        ((3.0, 0.0, 30.0), (0,)),
        ((15.0, 9.0, 30.0), (2,)),
        ((0.0, 30.0, 0.0), (2,)),
        ((0.0, 0.0, 3.5), (0, 1)),
        ((0.0, 0.0, 2.0), (2,)),
        ((3.0, 3.0, 9.0), (2,)),
    ],
)
def test_blocks_that_hold_nearly_all_of_the_gap_are_fitted(given, quiet, sizes, kept):
    holdout = hold_out([with_gap(quiet, sizes)])
    base = fit_base(given, holdout.experiments, holdout.fitted)
    assert np.argmax(gaps_of_blocks(holdout, base)) == np.argmax(sizes)
    parted, refitted = evenly_parted(holdout, base, given)
    assert parted.kept in kept
    assert (refitted is base) == (parted.kept == holdout.kept)
    (fitted,), (scored,) = parted.fitted, parted.scored
    assert set(quiet.block[scored] % EVERY) == {parted.kept}
    assert not (fitted & scored).any()
    assert (fitted | scored).all() == np.isfinite(quiet.position).all()
    assert refitted.problem.used[0] is fitted


def test_of_several_records_the_last_one_is_scored_whatever_it_shows(given, quiet):
    other = replace(with_gap(quiet, (30.0, 30.0, 30.0)), name="other")
    holdout = hold_out([quiet, other])
    base = fit_base(given, holdout.experiments, holdout.fitted)
    assert evenly_parted(holdout, base, given) == (holdout, base)
