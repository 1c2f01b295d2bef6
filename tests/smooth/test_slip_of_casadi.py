"""The smooth slip's closed forms against the matrix exponential, on both sides of critical damping."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from valvemodel.smooth.slip import stop_time, transition

ARGUMENTS = ca.SX.sym("a", 4)
MAP = ca.Function("map", [ARGUMENTS], [ca.vertcat(*transition(*ca.vertsplit(ARGUMENTS)))])
STOP_ARGUMENTS = ca.SX.sym("s", 5)
STOP = ca.Function("stop", [STOP_ARGUMENTS], [stop_time(*ca.vertsplit(STOP_ARGUMENTS))])

MASS, SPRING = 1.36, 52500.0
CRITICAL = 2.0 * np.sqrt(MASS * SPRING)


def exact(mass, damping, stiffness, duration):
    """Velocity and way, by velocity and by force, from the matrix exponential of (way, velocity, force)."""
    system = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]])
    through = expm(system * duration)
    return np.array([through[1, 1], through[1, 2], through[0, 1], through[0, 2]])


@pytest.mark.parametrize("damping", [0.0, 1.59, 60.0, 0.9999 * CRITICAL, CRITICAL, 1.0001 * CRITICAL, 612.9, 2e4])
@pytest.mark.parametrize("duration", [1e-6, 1e-3, 0.01, 0.1])
def test_transition_is_the_matrix_exponential(damping, duration):
    found = MAP([MASS, damping, SPRING, duration]).full().ravel()
    # The way by force cancels over short durations: beside the way that the spring allows it is nothing.
    scale = np.array([1.0, duration / MASS, duration, duration**2 / MASS])
    assert found / scale == pytest.approx(exact(MASS, damping, SPRING, duration) / scale, abs=3e-5)
    assert found == pytest.approx(exact(MASS, damping, SPRING, duration), abs=1e-12, rel=1e-9)


@pytest.mark.parametrize("damping", [0.0, 50.0, 612.9])
def test_a_stem_without_a_spring_is_included(damping):
    found = MAP([MASS, damping, 0.0, 0.01]).full().ravel()
    assert found == pytest.approx(exact(MASS, damping, 0.0, 0.01), rel=1e-8)


@pytest.mark.parametrize("damping", [1.59, 60.0, 612.9])
def test_derivatives_are_finite_everywhere(damping):
    slopes = MAP.jacobian()
    for stiffness in (0.0, SPRING, damping**2 / 4.0 / MASS):
        assert np.isfinite(slopes([MASS, damping, stiffness, 0.01], MAP([MASS, damping, stiffness, 0.01])).full()).all()


@pytest.mark.parametrize("damping", [1.59, 60.0, 612.9, 2e4])
@pytest.mark.parametrize("net", [-3000.0, -200.0, 50.0])
def test_speed_is_zero_at_the_stop_time(damping, net):
    speed = 0.4
    time = float(STOP([MASS, damping, SPRING, speed, net]))
    if time > 1e3:
        assert net > 0.0
        assert damping > CRITICAL
        return
    by_velocity, by_force, _, _ = exact(MASS, damping, SPRING, time)
    assert by_velocity * speed + by_force * net == pytest.approx(0.0, abs=1e-12)


def test_a_stem_at_rest_that_nothing_drives_has_stopped():
    assert float(STOP([MASS, 1.59, SPRING, 0.0, -100.0])) == 0.0
    assert float(STOP([MASS, 612.9, SPRING, 0.0, -100.0])) == 0.0
