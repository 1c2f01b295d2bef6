"""What cannot be in a valve does not win unless it is in the data; a black box closes what a smooth correction can."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from diagnosis.judging.ceiling import ceiling_of
from diagnosis.judging.sham import control_of, shams_on, smooth_noise
from diagnosis.score import closed_share
from diagnosis.trying.candidates import Work, try_effect
from diagnosis.trying.explaining import stops_seen


def test_no_sham_wins_where_nothing_is_missing(quiet, refitted):
    base, holdout = refitted(quiet)
    control = control_of([base], shams_on(base, holdout), "free")
    assert control.probability < 0.5
    assert control.notes == []


def test_no_sham_wins_beside_the_effect_that_is_there(quiet, refitted):
    creep = 4e-3 * quiet.time / quiet.time[-1]
    base, holdout = refitted(quiet, creep)
    drift = try_effect(Work(base.fit, ("sensor_drift",), is_global=True), holdout)
    assert drift.score.misfit < 0.5 * base.score.misfit
    assert control_of([base, drift], shams_on(base, holdout), "free").probability < 1e-3


def test_sham_wins_where_it_is_in_the_data(quiet, refitted):
    generator = np.random.default_rng(0)
    scale = float(np.exp(generator.uniform(*np.log((0.5, 30.0)))))
    base, holdout = refitted(quiet, 20.0 * quiet.noise * smooth_noise(generator, quiet.time, scale, 1)[:, 0])
    best = min(shams_on(base, holdout, count=1), key=lambda sham: sham.score.misfit)
    assert best.score.free.rms < 0.5 * base.score.free.rms
    control = control_of([base], shams_on(base, holdout), "free")
    assert control.probability > 0.5
    assert "too little" in control.notes[0]


@pytest.mark.parametrize(("count", "scale"), [(7501, 0.5), (7501, 30.0), (1000, 0.1)])
def test_waves_of_a_sham_are_noise_through_a_gaussian_filter(count, scale):
    time = 0.02 * np.arange(count)
    waves = smooth_noise(np.random.default_rng(4), time, scale, 2)
    noise = np.random.default_rng(4).standard_normal((count, 2))
    filtered = gaussian_filter1d(noise, scale / 0.02, axis=0, mode="wrap", truncate=8.0)
    filtered = (filtered - filtered.mean(axis=0)) / filtered.std(axis=0)
    assert waves == pytest.approx(filtered, abs=1e-3)


def test_black_box_closes_a_bow_and_nothing_of_noise(quiet, refitted):
    span = np.ptp(quiet.position)
    bow = 0.02 * span * np.sin(3.0 * np.pi * (quiet.position - quiet.position.min()) / span)
    base, holdout = refitted(quiet, bow)
    after = ceiling_of(base.fit, holdout, is_anchored=False)
    assert closed_share(base.score.free.rms, after.rms, holdout.floor) > 0.8
    base, holdout = refitted(quiet)
    assert ceiling_of(base.fit, holdout, is_anchored=False).rms == pytest.approx(base.score.free.rms, rel=0.05)


def test_shams_are_judged_where_the_stem_rests_on_its_way(quiet, refitted):
    stairs = 12.0 * quiet.noise
    steps = np.round(quiet.position / stairs) * stairs - quiet.position
    base, holdout = refitted(quiet, steps)
    assert stops_seen(base.fit)
    assert 0.0 <= control_of([base], shams_on(base, holdout), "free").probability <= 1.0
