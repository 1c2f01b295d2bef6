"""Motions whose answer is known in closed form."""

import math

import mpmath as mp
import numpy as np
import pytest
from exact_chain import ExactValve
from simulation_runs import base_model, ramps_and_steps, run

from valvemodel import chain
from valvemodel.simulation import simulate
from valvemodel.stages.slip import STOP_SPEED, first_stop, slip_end, swing_out, time_of_way, transition

RATE = 52500.0
MASS = 1.36

ROOM = {"travel_min": -10.0, "travel_max": 10.0}


def held(model, pressure, *, start, seconds=1.0, rate=1000.0):
    time = np.arange(int(seconds * rate) + 1) / rate
    return time, run(model, time, np.full_like(time, pressure), driven_by=chain.PRESSURE, start=start)


def exact_transition(mass: float, damping: float, stiffness: float, duration: float) -> list:
    m, c, k, t = map(mp.mpf, (mass, damping, stiffness, duration))
    power = mp.expm(mp.matrix([[0, 1, 0], [0, 0, 1], [0, -k / m, -c / m]]) * t)
    return [power[1, 1], power[1, 2], power[2, 1], power[2, 2], power[0, 1], power[0, 2]]


CRITICAL = 2.0 * math.sqrt(MASS * RATE)
SLIPS: dict[str, tuple[float, ...]] = {
    "overdamped": (MASS, 612.9, RATE),
    "underdamped": (MASS, 1.59, RATE),
    "critical": (MASS, CRITICAL, RATE),
    "just above critical": (MASS, CRITICAL * (1.0 + 1e-9), RATE),
    "just below critical": (MASS, CRITICAL * (1.0 - 1e-9), RATE),
    "no spring": (MASS, 612.9, 0.0),
    "no spring, no damping": (MASS, 0.0, 0.0),
    "no damping": (MASS, 0.0, RATE),
    "weak spring": (MASS, 612.9, 1e-3),
    "falling spring": (MASS, 612.9, -8000.0),
    "falling friction": (MASS, -300.0, RATE),
}


@pytest.mark.parametrize("slip", SLIPS.values(), ids=list(SLIPS))
@pytest.mark.parametrize("duration", [1e-12, 1e-7, 3e-5, 1e-3, 7e-3, 2e-2, 0.1])
def test_transition_has_thirteen_digits(slip, duration):
    with mp.workdps(50):
        expected = exact_transition(*(*slip, duration))
    envelope = max(1.0, math.exp(-0.5 * slip[1] / slip[0] * duration))
    # Sizes below which rounding of the larger terms shows; relative above.
    floors = [envelope, duration * envelope, abs(slip[2] / slip[0]) * duration * envelope, envelope, 0.0, 0.0]
    for found, true, floor in zip(transition(*(*slip, duration)), expected, floors, strict=True):
        assert abs(found - true) <= 2e-13 * max(abs(true), 1e-3 * floor)


@pytest.mark.parametrize("slip", SLIPS.values(), ids=list(SLIPS))
@pytest.mark.parametrize("speed", [1e-9, 1e-3, 0.5])
@pytest.mark.parametrize("deceleration", [0.3, 40.0, 2000.0])
def test_first_stop_is_where_the_speed_is_zero(slip, speed, deceleration):
    stop = first_stop(*(*slip, speed, -deceleration))
    if stop > 1.0 and slip[1] > 0.0 and slip[2] > 1.0:
        # At critical damping a stop after hundreds of time constants is rounding.
        late = transition(*(*slip, 0.05))
        assert late[0] * speed - late[1] * deceleration >= 0.0
        return
    if math.isinf(stop):
        # A driven stem without a spring, or a falling one.
        assert slip[2] <= 1e-3
        late = transition(*(*slip, 10.0))
        assert late[0] * speed - late[1] * deceleration >= 0.0
        return
    with mp.workdps(50):
        vv, va, av, aa, _, _ = exact_transition(*(*slip, stop))
        left = vv * mp.mpf(speed) - va * mp.mpf(deceleration)
        slope = av * mp.mpf(speed) - aa * mp.mpf(deceleration)
        assert abs(left / slope) <= 1e-13 * stop
        for share in (0.1, 0.5, 0.9, 0.999):
            vv, va, *_ = exact_transition(*(*slip, share * stop))
            assert vv * mp.mpf(speed) - va * mp.mpf(deceleration) > 0


@pytest.mark.parametrize("damping", [0.0, 1.59, 60.0, 500.0])
@pytest.mark.parametrize(("speed", "acceleration"), [(0.5, 300.0), (0.02, -1.5), (3e-6, 40.0)])
def test_swing_out_ends_where_the_slip_stops(damping, speed, acceleration):
    slip = (MASS, damping, RATE)
    stop = first_stop(*slip, speed, acceleration)
    alpha = 0.5 * damping / MASS
    way, at_stop = swing_out(alpha, math.sqrt(RATE / MASS - alpha**2), speed, acceleration, stop)
    with mp.workdps(50):
        _, _, av, aa, yv, ya = exact_transition(*slip, stop)
        amplitude = (abs(acceleration) + math.sqrt(RATE / MASS) * speed) * MASS / RATE
        assert abs(way - (yv * speed + ya * acceleration)) <= 2e-15 * amplitude
        assert abs(at_stop - (av * speed + aa * acceleration)) <= 1e-14 * amplitude * RATE / MASS


@pytest.mark.parametrize("name", ["overdamped", "just above critical", "weak spring"])
@pytest.mark.parametrize("excess", [-1e-3, -140.0])
def test_slip_end_is_the_later_of_the_two_instants(name, excess):
    slip = SLIPS[name]
    speed, acceleration = 0.02, 3.0
    if name == "weak spring":
        acceleration = -9.0
    high = 20.0 if name == "weak spring" else 0.5
    end = slip_end(*slip, speed, acceleration, excess, STOP_SPEED, high)
    with mp.workdps(40):

        def beyond(t):
            vv, va, av, aa, _, _ = exact_transition(*(*slip, t))
            v, a = vv * speed + va * acceleration, av * speed + aa * acceleration
            return max(v - STOP_SPEED, slip[1] * v + slip[0] * a + excess)

        low, top = mp.mpf(0.003), mp.mpf(high)
        assert beyond(low) > 0
        for _ in range(60):
            middle = (low + top) / 2
            low, top = (middle, top) if beyond(middle) > 0 else (low, middle)
        # An ulp of the speed moves the instant by so much.
        assert abs(end - top) < 1e-11 * max(float(top), 1.0)


def test_time_of_way_inverts_the_way():
    for slip in SLIPS.values():
        duration = 0.004
        way = transition(*(*slip, duration))[4] * 0.3 + transition(*(*slip, duration))[5] * 5.0
        assert time_of_way(*(*slip, 0.3, 5.0, way, 0.01, 0.0)) == pytest.approx(duration, rel=1e-12)
        steady = 0.2
        way += steady * duration
        assert time_of_way(*(*slip, 0.3, 5.0, way, 0.01, steady)) == pytest.approx(duration, rel=1e-9)


def test_free_decay_follows_the_damped_sine():
    model = base_model(viscous_friction=40.0, coulomb_friction=0.0, **ROOM)
    time, position = held(model, 0.0, start=0.05)
    alpha = 0.5 * 40.0 / MASS
    beta = math.sqrt(RATE / MASS - alpha**2)
    expected = 0.05 * np.exp(-alpha * time) * (np.cos(beta * time) + alpha / beta * np.sin(beta * time))
    assert np.abs(position - expected).max() < 1e-13


def test_coulomb_oscillator_loses_two_friction_over_rate_each_half_swing():
    friction = 60.0
    model = base_model(viscous_friction=0.0, coulomb_friction=friction, **ROOM)
    half_swing = math.pi * math.sqrt(MASS / RATE)
    amplitude = 0.05
    time = np.arange(15) * half_swing * (1.0 + 1e-12)
    position = run(model, time, np.zeros(15), driven_by=chain.PRESSURE, start=amplitude)
    loss = 2.0 * friction / RATE
    expected = [(-1.0) ** n * (amplitude - n * loss) for n in range(15)]
    assert np.abs(position - expected).max() < 1e-13


def test_coulomb_oscillator_inside_one_long_period_comes_to_rest_where_it_must():
    friction = 60.0
    model = base_model(viscous_friction=0.0, coulomb_friction=friction, **ROOM)
    _, position = held(model, 0.0, start=0.05, seconds=60.0, rate=1.0 / 60.0)
    loss = 2.0 * friction / RATE
    swings = math.ceil((0.05 - friction / RATE) / loss)
    assert position[-1] == pytest.approx((-1.0) ** swings * (0.05 - swings * loss), abs=1e-13)


def test_ramped_force_breaks_away_at_the_breakaway_force():
    model = base_model().with_effect("static_friction", static_friction_ratio=1.25)
    rate = 500.0
    time = np.arange(60001) / 1000.0
    force = rate * time
    pressure = force / 0.0645
    position = run(model, time, pressure, driven_by=chain.PRESSURE, start=0.0)
    moved = int(np.argmax(position > 0.0))
    # Row k shows the state before drive k; the drive that moved it is the one before.
    assert force[moved - 1] > 1.25 * 1423.0 >= force[moved - 2]


@pytest.mark.parametrize(("damping", "share"), [(612.9, 1.0), (0.0, 2.0)])
def test_slip_jump(damping, share):
    """(F_s - F_c)/k overdamped, twice that undamped."""
    coulomb, ratio = 400.0, 1.5
    model = base_model(viscous_friction=damping, coulomb_friction=coulomb, **ROOM)
    model = model.with_effect("static_friction", static_friction_ratio=ratio)
    pressure = ratio * coulomb * (1.0 + 1e-11) / 0.0645
    _, position = held(model, pressure, start=0.0)
    assert position[-1] == pytest.approx(share * (ratio - 1.0) * coulomb / RATE, rel=1e-4 if damping else 1e-9)


def test_stem_without_a_spring_creeps_at_net_force_over_damping():
    model = base_model(spring_rate=0.0, coulomb_friction=100.0, **ROOM)
    time, position = held(model, 2000.0, start=0.0)
    net, damping = 0.0645 * 2000.0 - 100.0, 612.9
    expected = net / damping * (time + MASS / damping * np.expm1(-damping / MASS * time))
    assert np.abs(position - expected).max() < 1e-14


@pytest.mark.parametrize("damping", [612.9, 1.59])
@pytest.mark.parametrize("ratio", [1.0, 1.2])
@pytest.mark.parametrize("period", [0.02, 0.31])
def test_twelve_digits_against_fifty(damping, ratio, period):
    count = 240 if period < 0.1 else 40
    _, current = ramps_and_steps(seconds=(count - 1) / 50.0, seed=3)
    model = base_model(viscous_friction=damping)
    if ratio > 1.0:
        model = model.with_effect("static_friction", static_friction_ratio=ratio)
    time = np.arange(count) * period
    found = run(model, time, current)
    with mp.workdps(50):
        exact = ExactValve(dict(model.values), ratio)
        expected = exact.run(current.tolist(), period)
        # Overdamped with F_s = F_c a stem only creeps.
        assert exact.stops > 3 or (ratio == 1.0 and damping > 600.0)
        worst = max(abs(mp.mpf(a) - b) for a, b in zip(found.tolist(), expected, strict=True))
    assert worst < 1e-12 * 0.25


def test_a_slip_stops_dead_at_the_end_of_the_travel():
    model = base_model(viscous_friction=1.59, travel_max=0.2, travel_min=0.05)
    time = np.arange(400) / 100.0
    current = np.where((time % 2.0) < 1.0, 20e-3, 4e-3)
    position = run(model, time, current)
    assert position.max() == 0.2
    assert position.min() == 0.05
    assert (position[50:99] == 0.2).all()


@pytest.mark.parametrize("restitution", [0.3, 0.9])
def test_a_bouncing_stem_keeps_the_square_of_its_restitution(restitution):
    """Thrown back with e v, a stem under a constant force comes back by e^2 of the way, for e times as long."""
    model = base_model(
        spring_rate=0.0,
        viscous_friction=0.0,
        coulomb_friction=0.0,
        travel_min=0.0,
        travel_max=0.1,
        restitution=restitution,
    )
    pressure = 1000.0
    acceleration = model.values["diaphragm_area"] * pressure / MASS
    fall = math.sqrt(2.0 * 0.1 / acceleration)
    time = np.array([0.0, fall * (1.0 + restitution), fall * (1.0 + 2.0 * restitution + restitution**2), 10.0])
    positions = run(model, time, np.full(4, pressure), driven_by=chain.PRESSURE, start=0.0)
    assert positions[1:] == pytest.approx([0.1 * (1.0 - restitution**2), 0.1 * (1.0 - restitution**4), 0.1], abs=1e-13)


@pytest.mark.parametrize("short", [1e-6, 1e-5, 1e-4, 1e-3])
def test_a_stem_that_turns_just_beyond_the_end_of_its_travel_does_not_get_there(short):
    """Its speed falls to 0 within the same small part of a step in which it passes the end."""
    ringing = base_model(viscous_friction=30.0).with_effect("load_force", load_sine=1.0)
    time = np.arange(60) / 50.0
    current = np.where(time < 0.1, 8e-3, 16e-3)
    peak = simulate(ringing, time=time, current=current).events.position.max()
    blocked = simulate(ringing.with_values(travel_max=peak - short), time=time, current=current).events
    assert blocked.position.max() <= peak - short
    assert "impact" in blocked.kind
