"""Stops that give way: against closed forms, plain Python, an independent integration, and stops that do not."""

import math

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, with_effects

from identification.problem import FINE_TOLERANCE, SEARCH_TOLERANCE
from valvemodel import chain
from valvemodel.loops import settles_in_closed_form
from valvemodel.reference import simulate_slowly
from valvemodel.simulation import simulate
from valvemodel.trajectory import TOLERANCE

STOPS = {"upper_stop": 0.15, "lower_stop": 0.09}
COMPLIANCES = [2e-9, 2e-7, 2e-6]


def stopped(compliance, model=None, **stops):
    return (model or base_model()).with_effect("end_stop", **(stops or STOPS), stop_compliance=compliance)


@pytest.mark.parametrize("compliance", COMPLIANCES)
@pytest.mark.parametrize("damping", [612.9, 1.59])
def test_run_is_the_same_in_plain_python(damping, compliance):
    model = stopped(compliance, base_model(viscous_friction=damping))
    time, current = ramps_and_steps(seconds=15.0, seed=1)
    found, expected = (make(model, time=time, current=current) for make in (simulate, simulate_slowly))
    assert (found.mode == expected.mode).all()
    assert np.abs(found.position - expected.position).max() < 5e-14
    assert found.position.max() > STOPS["upper_stop"]
    assert found.position.min() < STOPS["lower_stop"]


BESIDE = [
    (), ("static_friction",), ("stribeck",), ("presliding",), ("chamber_filling",), ("coil_lag",), ("load_force",),
    ("friction_drift",), ("spring_hardening",), ("area_variation",), ("position_dependent_friction",),
    ("linkage_backlash", "linkage_nonlinearity"),
]  # fmt: skip


@pytest.mark.parametrize("keys", BESIDE, ids=" ".join)
def test_run_is_within_its_tolerance_of_an_independent_integration(keys):
    model = stopped(2e-7, with_effects(base_model(), *keys))
    time, current = ramps_and_steps(seconds=3.0, seed=1)
    expected = IndependentChain.of(model).run(time, current)
    for tolerance, bound in {TOLERANCE: 1e-9, FINE_TOLERANCE: 1e-7, SEARCH_TOLERANCE: 5e-5}.items():
        assert np.abs(run(model, time, current, tolerance=tolerance) - expected).max() < bound, tolerance


@pytest.mark.parametrize("compliance", [0.0, 2e-9, 2e-7])
@pytest.mark.parametrize("law", [{}, {"slider_share": 1.0}])
def test_a_stem_on_bristles_starts_alike_a_hair_off_its_stop_and_on_it(compliance, law):
    stop = 0.08
    model = with_effects(base_model()).with_effect("presliding", presliding_compliance=2e-6, **law)
    model = model.with_effect("end_stop", upper_stop=np.inf, lower_stop=stop, stop_compliance=compliance)
    n = model.numbers
    time = np.arange(100) / 50.0
    push = n["coulomb_friction"] * np.linspace(-3.0, 0.5, time.size)
    pressure = (n["spring_rate"] * stop + n["spring_preload"] + push) / n["diaphragm_area"]
    runs = [run(model, time, pressure, driven_by=chain.PRESSURE, start=stop + off) for off in (1e-6, 0.0, -1e-6)]
    assert np.abs(np.diff(runs, axis=0)).max() < 2e-5
    # It leaves the stop as soon as the force no longer presses it there, as its bristles are bent the other way.
    assert runs[0][-1] > stop + 5e-4


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_depth_follows_the_pressure_with_the_friction_of_its_direction(side):
    """S_1 P - F_0 -+ F_c = k y + (y - y_s)/C going in and out, and the stem holds in between."""
    compliance, stop, model = 4e-7, 0.12, base_model(viscous_friction=2e4)
    name = "upper_stop" if side > 0.0 else "lower_stop"
    model = stopped(compliance, model, **{name: stop})
    n = model.numbers
    area, rate, friction = n["diaphragm_area"], n["spring_rate"], n["coulomb_friction"]
    at_stop = (rate * stop + n["spring_preload"]) / area
    push = friction * np.array([0.0, 2.0, 4.0, 2.5, 0.5])
    pressure = at_stop + side * push / area
    found = run(model, np.arange(6.0), np.append(pressure, pressure[-1]), driven_by=chain.PRESSURE, start=stop)[1:]
    going_in, going_out = ((push + sign * friction) / (rate + 1.0 / compliance) for sign in (-1.0, 1.0))
    expected = [0.0, going_in[1], going_in[2], going_in[2], going_out[4]]
    assert side * (found - stop) == pytest.approx(expected, abs=1e-12)


def test_stem_without_friction_comes_back_as_fast_as_it_came():
    """It stays for half a swing of sqrt((k + 1/C)/m), and turns at the depth that takes up its energy."""
    compliance, stop = 1e-6, 0.1
    model = base_model(spring_rate=0.0, viscous_friction=0.0, coulomb_friction=0.0)
    model = stopped(compliance, model, upper_stop=stop)
    mass, force = model.values["stem_mass"], 50.0
    pressure = force / model.values["diaphragm_area"]
    reaching = math.sqrt(2.0 * mass * stop / force)
    speed, rate = force * reaching / mass, math.sqrt(1.0 / (compliance * mass))
    # The push goes on in the stop: the swing is about force times compliance, from force x compliance short of it.
    short = force * compliance
    half = (math.pi + 2.0 * math.atan(short * rate / speed)) / rate
    deepest = short + math.hypot(short, speed / rate)
    time = np.array([0.0, reaching, reaching + 0.5 * half, reaching + half, 2.0 * reaching + half])
    found = run(model, time, np.full(5, pressure), driven_by=chain.PRESSURE, start=0.0)
    assert found == pytest.approx([0.0, stop, stop + deepest, stop, 0.0], abs=1e-11)


def test_the_stiffer_a_stop_the_more_it_is_a_dead_one():
    time, current = ramps_and_steps(seconds=10.0, seed=3)
    dead = run(base_model().with_effect("end_stop", **STOPS), time, current)
    apart = [np.abs(run(stopped(compliance), time, current) - dead).max() for compliance in (1e-7, 1e-9, 1e-11, 1e-13)]
    assert apart[0] > apart[1] > apart[2] > apart[3]
    # It bounces off the stiffest as off the others.
    assert apart[3] < 1e-6


def test_no_energy_is_lost_in_a_stop():
    time, current = ramps_and_steps(seconds=6.0, seed=3)
    lossless = base_model(viscous_friction=0.0, coulomb_friction=0.0)
    energies = simulate(stopped(2e-7, lossless), time=time, current=current).energies
    assert np.abs(energies.dissipated).max() < 1e-7 * np.abs(energies.supplied).max()
    assert energies.stored.max() > 0.0


def test_coming_to_a_stop_and_leaving_it_are_events():
    time, current = ramps_and_steps(seconds=6.0, seed=3)
    events = simulate(stopped(2e-7), time=time, current=current).events
    at_stops = np.isin(events.kind, ["impact", "release"])
    assert set(events.position[at_stops]) == set(STOPS.values())
    kinds = events.kind[at_stops]
    assert (kinds[1:] != kinds[:-1]).all()
    assert len(kinds) > 4
    assert (events.speed[at_stops] > 0.0).all()


@pytest.mark.parametrize("compliance", [1e-10, 1e-8, 1e-7])
@pytest.mark.parametrize("stop", ["upper_stop", "lower_stop"])
def test_stem_is_put_no_deeper_into_a_stop_than_where_friction_holds_it(stop, compliance):
    """A reading that is off by its noise would throw it back, the harder the stiffer the stop."""
    side = 1.0 if stop == "upper_stop" else -1.0
    model = stopped(compliance, **{stop: 0.12})
    time, current = np.linspace(0.0, 1.0, 51), np.full(51, 12e-3 + side * 2e-3)
    found, expected = (
        make(model, time=time, current=current, start_position=0.12 + side * 1e-3)
        for make in (simulate, simulate_slowly)
    )
    assert found.position == pytest.approx(expected.position, abs=1e-13)
    assert side * (found.position[0] - 0.12) < 2e-2 * compliance / 1e-6
    assert np.ptp(found.position) < 1e-12
    measured = np.full(51, 0.12 + side * 1e-3)
    again = simulate(model, time=time, current=current, measured=measured, reanchor=0.5)
    assert np.ptp(again.position) < 1e-12


def test_a_settled_loop_with_it_has_no_closed_form():
    assert settles_in_closed_form(base_model().with_effect("end_stop", **STOPS))
    assert not settles_in_closed_form(stopped(1e-7))


@pytest.mark.parametrize("compliance", [2e-11, 2e-9, 2e-8, 2e-7, 2e-6])
@pytest.mark.parametrize("key", ["chamber_filling", "coil_lag", "supply_droop", "load_force"])
def test_a_search_lets_a_pressed_stem_follow_the_force_within_a_few_of_its_tolerances(key, compliance):
    """A pressure or load that moves pushes it into the stop as far as friction lets it, swing by swing or at once."""
    model = stopped(compliance, with_effects(base_model(), key))
    time, current = ramps_and_steps(seconds=12.0, seed=1)
    exact, searched = (run(model, time, current, tolerance=tolerance) for tolerance in (TOLERANCE, SEARCH_TOLERANCE))
    dead = run(model.with_effect("end_stop", **STOPS, stop_compliance=0.0), time, current)
    off = np.abs(searched - exact)
    assert np.sqrt(np.mean(off**2)) < 0.5 * SEARCH_TOLERANCE
    assert off.max() < 5.0 * SEARCH_TOLERANCE
    if compliance >= 2e-8:
        assert np.abs(exact - dead).max() > 4.0 * off.max()
