"""Self-calibration, eqs. (35)-(40): right on straight branches, and honest where it is biased."""

from __future__ import annotations

import numpy as np
import pytest

from identification.self_calibration import calibrate, calibrate_record
from valvemodel.errors import InputError
from valvemodel.loops import settle_loop, shape_of_loop
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.valves import read_valve

SLOPE, WIDTH = 12.0, 4e-3  # m/A, A
RISING, FALLING = np.array([9e-3, 11e-3, 13e-3]), np.array([10e-3, 8e-3, 6e-3])


def on_branches(rising: np.ndarray = RISING, falling: np.ndarray = FALLING) -> dict[str, np.ndarray]:
    return {
        "rising_current": rising,
        "rising_position": SLOPE * (rising - 0.5 * WIDTH),
        "falling_current": falling,
        "falling_position": SLOPE * (falling + 0.5 * WIDTH),
    }


def loop_record(name: str, current: np.ndarray, noise: float = 0.0) -> tuple[Model, Record]:
    valve = read_valve(name)
    model = Model(valve.name, valve.values)
    position = settle_loop(model, current=current)
    position = position + noise * np.random.default_rng(2).standard_normal(len(position))
    return model, Record.from_arrays(name, current=current, position=position)


SWEEP = np.concatenate([np.arange(4.0, 18.01, 0.5), np.arange(17.5, 3.99, -0.5)]) * 1e-3


def test_straight_branches_give_the_full_width() -> None:
    found = calibrate(**on_branches())
    assert found.width == pytest.approx(WIDTH, rel=1e-12)
    assert found.slope == pytest.approx(SLOPE, rel=1e-12)
    assert found.warnings == ()


def test_deviation_is_that_of_repetitions() -> None:
    generator = np.random.default_rng(3)
    noise = 2e-4
    widths, stated = [], []
    for _ in range(400):
        points = on_branches()
        for name in ("rising_position", "falling_position"):
            points[name] = points[name] + noise * generator.standard_normal(3)
        found = calibrate(**points, noise=noise)
        widths.append(found.width)
        stated.append(found.std)
    assert np.mean(stated) == pytest.approx(np.std(widths), rel=0.1)
    assert np.mean(widths) == pytest.approx(WIDTH, rel=0.002)


def test_point_in_the_dead_band_is_warned_of() -> None:
    points = on_branches()
    points["rising_position"] = points["rising_position"] + np.array([0.01, 0.0, 0.0])
    found = calibrate(**points)
    assert abs(found.width / WIDTH - 1.0) > 0.03
    assert any("dead band" in warning for warning in found.warnings)


def test_noise_and_branches_that_are_no_loop_are_warned_of() -> None:
    assert any("noise alone" in warning for warning in calibrate(**on_branches(), noise=5e-3).warnings)
    points = on_branches()
    points["falling_position"] = points["falling_position"] - 0.1
    assert any("no friction's loop" in warning for warning in calibrate(**points).warnings)


def test_points_that_give_no_width_are_refused() -> None:
    with pytest.raises(InputError, match="the currents of a branch differ"):
        calibrate(**on_branches(rising=np.array([9e-3, 9e-3, 13e-3])))
    points = on_branches()
    points["rising_position"] = points["rising_position"][::-1]
    points["falling_position"] = points["falling_position"][::-1]
    with pytest.raises(InputError, match="rises with the current"):
        calibrate(**points)


def test_points_are_chosen_from_a_loop() -> None:
    model, record = loop_record("linear", SWEEP)
    found = calibrate_record(record)
    truth = shape_of_loop(model, position=0.1, highest_current=0.03)
    assert found.width == pytest.approx(truth.width, rel=1e-6)
    assert found.warnings == ()


def test_curvature_is_warned_of() -> None:
    _, record = loop_record("calibrated", SWEEP)
    assert calibrate_record(record).warnings != ()


def test_one_way_record_is_refused() -> None:
    _, record = loop_record("calibrated", SWEEP[:29])
    with pytest.raises(InputError, match="moves up and down"):
        calibrate_record(record)
