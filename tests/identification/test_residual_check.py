"""The residual check passes white residuals at its stated level and fails each fault by the test that looks for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identification.experiment import Experiment
from identification.results.residual_check import INPUT_LAGS, checks_of

COUNT = 3000


def experiment() -> tuple[Experiment, np.ndarray]:
    time = np.arange(COUNT) * 0.02
    current = 12e-3 + 6e-3 * np.sin(0.5 * time) + 2e-3 * (time % 7.0 > 3.5)
    position = 0.15 + 0.1 * np.sin(0.5 * time)
    mode = np.sign(np.cos(0.5 * time)) * (np.abs(np.cos(0.5 * time)) > 0.3)
    return Experiment("made", time, current, position, None, 1.0, 0.0, (time // 3.0).astype(int)), mode


def failed(residual: np.ndarray) -> set[str]:
    made, mode = experiment()
    return {each.name for each in checks_of("position", [made], [residual], [mode]) if not each.is_passed}


def test_white_residuals_pass_at_the_stated_level() -> None:
    made, mode = experiment()
    generator = np.random.default_rng(1)
    results = [
        {
            each.name: each.is_passed
            for each in checks_of("position", [made], [generator.standard_normal(COUNT)], [mode])
        }
        for _ in range(200)
    ]
    for name in ("position: whiteness", "position: input"):
        assert 0.90 <= np.mean([each[name] for each in results]) <= 0.99, name
    regimes = [all(passed for name, passed in each.items() if name.split(": ")[1] not in
                   ("size", "whiteness", "input")) for each in results]  # fmt: skip
    assert np.mean(regimes) >= 0.92


def test_each_fault_fails_its_own_test() -> None:
    made, mode = experiment()
    noise = np.random.default_rng(5).standard_normal(COUNT)
    assert failed(noise) == set()
    assert failed(1.5 * noise) == {"position: size"}
    coloured = noise.copy()
    for number in range(1, COUNT):
        coloured[number] = 0.5 * coloured[number - 1] + np.sqrt(0.75) * noise[number]
    assert "position: whiteness" in failed(coloured)
    assert "position: input" in failed(noise + 40.0 * (made.current - made.current.mean()))
    assert "position: rising" in failed(noise + 0.2 * (mode > 0))
    assert "position: late" in failed(noise + 0.2 * (made.time > 40.0))
    since = np.maximum.accumulate(np.where(np.diff(mode, prepend=0.0) != 0.0, made.time, 0.0))
    assert "position: after reversal" in failed(noise + 0.6 * mode * (made.time - since < 1.0))


@pytest.mark.parametrize("lost", [slice(100, 400), slice(0, 1)])
def test_gaps_are_left_out(lost: slice) -> None:
    residual = np.random.default_rng(3).standard_normal(COUNT)
    residual[lost] = np.nan
    assert failed(residual) <= {"position: whiteness"}


def test_each_regime_of_two_records_is_tested_once() -> None:
    made, mode = experiment()
    half = COUNT // 2
    short = replace(
        made, time=made.time[:half], current=made.current[:half], position=0.5 * made.position[:half],
        block=made.block[:half],
    )  # fmt: skip
    noise = np.random.default_rng(7).standard_normal(COUNT)
    checks = checks_of("position", [made, short], [noise, noise[:half]], [mode, mode[:half]])
    names = [each.name for each in checks]
    assert names == [each.name for each in checks_of("position", [made], [noise], [mode])]
    early = checks[names.index("position: early")]
    assert early.looks_for == "a mean in the first third of each record, before 10 to 20 s"


def test_a_record_shorter_than_the_longest_delay_of_the_input_is_tested() -> None:
    made, mode = experiment()
    rows = slice(0, INPUT_LAGS[-1] // 2)
    short = replace(
        made, time=made.time[rows], current=made.current[rows], position=made.position[rows], block=made.block[rows]
    )
    noise = np.random.default_rng(9).standard_normal(COUNT)[rows]
    checks = {each.name: each for each in checks_of("position", [short], [noise], [mode[rows]])}
    assert checks["position: input"].is_passed
