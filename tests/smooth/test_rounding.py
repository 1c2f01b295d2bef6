"""Rounded kinks are what they round beyond the width, and have the slopes that they say."""

import casadi as ca
import numpy as np
import pytest

from valvemodel.smooth.rounding import dead_zone, gate, passed, ramp

POINTS = np.linspace(-3.0, 3.0, 601)


def of(function, *arguments):
    x = ca.SX.sym("x")
    return ca.Function("f", [x], [function(x, *arguments)])


def test_ramp_is_untouched_beyond_its_width():
    values = of(ramp, 1.0)(POINTS).full().ravel()
    outside = np.abs(POINTS) >= 1.0
    assert values[outside] == pytest.approx(np.maximum(POINTS, 0.0)[outside], abs=1e-15)
    assert 0.0 <= (values - np.maximum(POINTS, 0.0)).max() <= 0.1876


def test_gate_is_the_slope_of_ramp_and_ramp_is_twice_differentiable():
    x = ca.SX.sym("x")
    slope = ca.Function("slope", [x], [ca.jacobian(ramp(x, 0.7), x)])(POINTS).full().ravel()
    assert of(gate, 0.7)(POINTS).full().ravel() == pytest.approx(slope, abs=1e-14)
    second = np.diff(slope) / np.diff(POINTS)
    assert np.abs(np.diff(second)).max() < 0.1


def test_dead_zone_tells_its_limits_apart():
    zone = of(dead_zone, 2.0, 1.0, 1e-6)
    assert [float(zone(x)) for x in (2.5, 1.5, -0.5, -1.5)] == pytest.approx([0.5, 0.0, 0.0, -0.5], abs=1e-9)


def test_passed_is_smooth_at_zero():
    x = np.array([-1e-2, -1e-9, 0.0, 1e-9, 9.99e-4, 1.01e-3, 1.0, 1e7])
    expected = [1.0 if abs(each) < 1e-12 else -np.expm1(-each) / each for each in x]
    assert of(passed)(x).full().ravel() == pytest.approx(expected, rel=1e-11)
