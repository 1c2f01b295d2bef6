"""Linearisations against central differences of the exact simulator, closed forms and python-control."""

from itertools import product

import control as ct
import numpy as np
import pytest
from linear_slips import slip_response

from valvemodel.errors import InputError
from valvemodel.linear import linearise
from valvemodel.linear.state_space import TREATMENTS, UNITS
from valvemodel.model import Model
from valvemodel.stages import EFFECTS
from valvemodel.stepping import SteppedValve
from valvemodel.valves import read_valve

SPEED, CHANGE = 1e-5, 1e-9
"""Slow and small: the way of 0.1 um hardly bends anything. [m/s], [A]"""

TIME = np.linspace(0.0, 5e-3, 6)
QUICK = {
    "coil_lag": {"coil_time_constant": 4e-3},
    "chamber_filling": {"chamber_filling_time": 8e-3},
    "asymmetric_filling": {"fill_time": 4e-3, "vent_time": 7e-3},
    "supply_droop": {"droop_gain": 0.2, "droop_recovery_time": 0.05},
    "sensor_lag": {"sensor_time_constant": 4e-3},
    "presliding": {"presliding_compliance": 1e-8},
    "stribeck": {"stribeck_ratio": 1.1, "stribeck_velocity": 0.3},
}
"""Quick enough to show in that time."""


TANH = {"saturation_slope": 0.0, "saturation_knee": 8e-3, "saturation_reach": 15e-3, "saturation_law": 1.0}


def valve(name: str = "calibrated", **effects: dict[str, float]) -> Model:
    found = read_valve(name)
    return Model(found.name, found.values, effects)


LINEAR = [effect.key for effect in EFFECTS if TREATMENTS[effect.key].is_linear and effect.key != "transport_delay"]
CASES = {key: valve(**{key: QUICK.get(key, {})}) for key in LINEAR} | {
    "calibrated": valve(),
    "linear": valve("linear"),
    "ringing": valve().with_values(viscous_friction=1.59),
    "filling of a gas": valve(chamber_filling={"chamber_filling_time": 8e-3, "filling_of_gas": 1.0}),
    "laminar filling": valve(
        chamber_filling={"chamber_filling_time": 8e-3, "filling_growth": 0.5, "laminar_filling": 0.6}
    ),
    "sag from the nozzle's air": valve(supply_droop={"droop_consumption": 0.3, "droop_recovery_time": 0.05}),
    "two lags": valve(sensor_lag={"sensor_time_constant": 4e-3, "sensor_second_time_constant": 2e-3}),
    "eddy currents": valve(coil_lag={"coil_time_constant": 4e-3, "eddy_time_constant": 2e-3}),
    "a filter alone": valve(sensor_lag={"sensor_time_constant": 0.0, "sensor_second_time_constant": 3e-3}),
    "a worn joint": valve(
        linkage_backlash={"backlash_half_width": 2e-3, "backlash_wear": 0.4}, sensor_lag=QUICK["sensor_lag"]
    ),
    "progressive": valve(spring_hardening={"spring_hardening": 2.0, "spring_progression": 1.5}),
    "choked and leaking": valve(choked_flow={}, air_leak={"leak_ratio": 0.2, "turbulent_leak_ratio": 0.3}),
    "saturating as tanh": valve(magnetic_saturation=TANH),
    "leaking as a gas": valve(air_leak={"leak_ratio": 0.1, "turbulent_leak_ratio": 0.2, "leak_chokes": 1.0}),
    "many": valve(
        **{key: QUICK.get(key, {}) for key in ("coil_lag", "chamber_filling", "sensor_lag", "spring_hardening",
        "area_variation", "magnetic_saturation", "linkage_nonlinearity", "position_dependent_friction")}
    ),
}  # fmt: skip

ROUNDING = 1e-14
"""Of the simulator's values, whose differences are taken."""


@pytest.mark.parametrize(("name", "mode"), list(product(CASES, ("rising", "falling"))))
def test_slip_answers_as_the_exact_simulator_differs(name, mode):
    model = CASES[name]
    found = linearise(model, current=11e-3, mode=mode, speed=SPEED)
    expected = slip_response(model, found.point, TIME, CHANGE)
    answer = ct.forced_response(found.system, TIME, np.full(len(TIME), CHANGE)).outputs
    for signal, values in zip(found.system.output_labels, answer, strict=True):
        difference = np.abs(values - expected[signal])[1:].max()
        rounding = ROUNDING * getattr(found.point, signal)
        assert difference < 1e-6 * np.abs(expected[signal]).max() + rounding, signal


def test_every_effect_says_how_it_enters():
    assert set(TREATMENTS) == {effect.key for effect in EFFECTS}


@pytest.mark.parametrize("law", [{}, {"bristle_damping": 400.0}, {"slider_share": 0.5, "bristle_damping": 400.0}])
def test_stuck_stem_yields_as_the_exact_simulator_on_its_bristles(law):
    model = valve(presliding={"presliding_compliance": 2e-6, **law})
    found = linearise(model, current=11e-3, mode="stuck")
    time = np.linspace(0.0, 0.02, 11)
    ends = []
    for change in (1e-9, -1e-9):
        stepped = SteppedValve(model, current=11e-3, tolerance=1e-14)
        ends.append([stepped.position, *(stepped.step(11e-3 + change, 2e-3) and stepped.position for _ in time[1:])])
    expected = 0.5 * (np.array(ends[0]) - np.array(ends[1]))
    answer = ct.forced_response(found.current_to_position, time, np.full(len(time), 1e-9)).outputs
    assert np.abs(answer - expected).max() < 1e-6 * expected.max()


def test_stuck_stem_without_bristles_does_not_move():
    found = linearise(valve(), current=12e-3, mode="stuck")
    assert found.current_to_reading.dcgain() == 0.0
    assert found.current_to_pressure.dcgain() > 0.0


def test_base_valve_is_spring_mass_and_damper():
    found = linearise(valve("linear"), current=12e-3)
    mass, damping, stiffness, area = 1.36, 612.9, 52500.0, 0.0645
    assert np.allclose(np.sort(found.system.poles()), np.sort(np.roots([mass, damping, stiffness])), rtol=1e-12)
    assert found.current_to_position.dcgain() == pytest.approx(area / stiffness * 10.625e6, rel=1e-12)
    assert found.point.position == pytest.approx((area * 125e3 - 1423.0) / stiffness, rel=1e-12)


def test_python_control_linearises_the_paper_s_equations_to_the_same():
    def rates(time, state, drive, parameters):
        position, velocity = state
        pressure = 3e5 / (1.0 + 1043661538.3905385 * (126.3e-6 - 750.1e-6 * np.sqrt(drive[0])) ** 2)
        return [velocity, (0.0645 * pressure - 52500.0 * position - 1423.0 - 612.9 * velocity) / 1.36]

    found = linearise(valve(), current=12e-3)
    paper = ct.nlsys(rates, None, inputs=1, states=2, outputs=2)
    judged = ct.linearize(paper, [found.point.position, 0.0], [12e-3], eps=1e-7)
    own = found.current_to_position
    assert np.allclose(own.A, judged.A, rtol=1e-6)
    assert np.allclose(own.B, judged.B, rtol=2e-5)


def test_signals_have_names_and_units():
    found = linearise(valve(coil_lag={}, sensor_lag={}), current=12e-3)
    assert found.system.input_labels == ["current"]
    assert found.system.output_labels == ["pressure", "position", "reading"]
    assert found.system.state_labels == ["coil_current", "stem_position", "stem_velocity", "transmitter_reading"]
    assert set(UNITS) == {"current", "pressure", "position", "reading"}


def test_equal_lags_in_series_are_the_square_of_one():
    lags = {"sensor_time_constant": 3e-3, "sensor_second_time_constant": 3e-3}
    found = linearise(valve(sensor_lag=lags), current=12e-3)
    assert found.system.state_labels[-2:] == ["transmitter_reading", "filter_filtered_reading"]
    omega = np.array([1.0, 100.0, 1000.0])
    ratio = found.current_to_reading(1j * omega) / found.current_to_position(1j * omega)
    assert np.abs(ratio * (1.0 + 3e-3j * omega) ** 2 - 1.0).max() < 1e-9


def test_dead_time_is_approximated_to_its_order():
    slow, fast = (linearise(valve(transport_delay={"transport_delay": delay}), current=12e-3) for delay in (0.4, 1e-9))
    omega = np.array([0.1, 1.0, 2.5])
    ratio = slow.current_to_pressure(1j * omega) / fast.current_to_pressure(1j * omega)
    assert np.abs(ratio - np.exp(-0.4j * omega)).max() < 1e-7


def test_a_line_that_smears_is_a_lag_behind_its_dead_time():
    sharp, smeared = (
        linearise(valve(transport_delay={"transport_delay": 0.4, "line_dispersion": dispersion}), current=12e-3)
        for dispersion in (0.0, 0.1)
    )
    omega = np.array([0.1, 1.0, 25.0])
    ratio = smeared.current_to_pressure(1j * omega) / sharp.current_to_pressure(1j * omega)
    assert np.abs(ratio * (1.0 + 0.04j * omega) - 1.0).max() < 1e-9


def test_friction_that_falls_with_speed_makes_a_slip_unstable():
    found = linearise(valve(stribeck={}), current=12e-3, speed=1e-3)
    assert found.current_to_position.poles().real.max() > 0.0


@pytest.mark.parametrize(
    ("model", "given", "rule"),
    [
        (valve(), {"current": 0.0}, "current above 0"),
        (valve(), {"current": 12e-3, "mode": "raising"}, "a mode"),
        (valve(), {"current": 12e-3, "speed": -1.0}, "speed"),
        (valve().with_values(travel_max=0.05), {"current": 12e-3}, "within the travel"),
        (valve().with_values(spring_rate=0.0), {"current": 12e-3}, "needs a spring"),
    ],
)
def test_no_operating_point_is_the_user_s_mistake(model, given, rule):
    with pytest.raises(InputError, match=rule):
        linearise(model, **given)
