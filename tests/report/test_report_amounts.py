"""Numbers read well at every size, and never say more than is known."""

from __future__ import annotations

import doctest

import numpy as np
import pytest

from diagnosis.report import amounts
from diagnosis.report.figures import envelope
from diagnosis.report.svg import equation_picture
from valvemodel.stages import EFFECTS


def test_examples_hold() -> None:
    assert doctest.testmod(amounts).failed == 0


@pytest.mark.parametrize(
    ("value", "std", "unit", "text"),
    [
        (1.4012, 0.0031, "1", "1.4012 ± 0.0031"),
        (52512.0, 431.0, "N/m", "52512 ± 431 N/m"),
        (2e-7, 1e-8, "m/N", "0.200 ± 0.010 µm/N"),
        (3.1e-9, 1.2e-10, "m/s", "3.10 ± 0.12 nm/s"),
        (4e-4, None, "A", "0.400 mA (uncertainty not determined)"),
        (None, None, "A", "not determined"),
        (float("inf"), 1.0, "m", "not determined"),
        (1.0, 0.0, "1", "1.000 ± 0"),
    ],
)
def test_amounts_with_uncertainty(value: float | None, std: float | None, unit: str, text: str) -> None:
    assert amounts.amount_with_std(value, std, unit) == text


def test_thinning_keeps_the_extremes_and_the_order() -> None:
    time = np.arange(100_000.0)
    values = np.sin(time / 5e3)
    values[[123, 77_777]] = [9.0, -9.0]
    values[40_000:40_400] = np.nan
    t, thinned = envelope(time, values, 500)
    assert len(t) <= 1000
    assert np.all(np.diff(t) > 0)
    assert (np.nanmin(thinned), np.nanmax(thinned)) == (-9.0, 9.0)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.key)
def test_equation_of_each_effect_can_be_typeset(effect) -> None:
    assert equation_picture("name", effect.equation).startswith("<svg")


def test_equation_that_cannot_be_typeset_is_left_to_text() -> None:
    assert equation_picture("name", r"\notacommand{x") == ""
