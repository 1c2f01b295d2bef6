"""What a record determines: structure on the exact simulator, sensitivities, profile and bootstrap side by side."""

from __future__ import annotations

import numpy as np
import pytest

from identification.determined.account import account_of, limits_of
from identification.determined.adequacy import ONE_WAY
from identification.determined.bootstrap import bootstrap
from identification.determined.neighbourhood import neighbourhood_of
from identification.determined.profile import profile
from identification.determined.sensitivity import directions_of, sensitivity_of
from identification.determined.structure import structure_of
from identification.determined.uncertainty import MANY_MINIMA, estimates
from identification.experiment import experiment_of
from identification.extending.extension import extend
from identification.fit import Fit, fit_base
from valvemodel.equations.symmetries import SCALINGS
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.simulation import simulate
from valvemodel.valves import read_valve

NOISE = 1e-4


def nominal() -> Model:
    valve = read_valve("calibrated")
    return Model(valve.name, valve.values)


def steps_and_ramps(duration: float = 40.0, rate: float = 50.0) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(round(duration * rate)) / rate
    levels = np.random.default_rng(3).uniform(5e-3, 19e-3, 200)
    current = np.where(time < 0.5 * duration, 12e-3 + 7e-3 * np.sin(0.6 * time), levels[(time / 1.1).astype(int)])
    return time, current


def record_of(model: Model, seed: int = 0, *, with_pressure: bool = False) -> Record:
    time, current = steps_and_ramps()
    run = simulate(model, time=time, current=current)
    generator = np.random.default_rng(seed)
    position = run.position + NOISE * generator.standard_normal(len(time))
    pressure = run.pressure + 300.0 * generator.standard_normal(len(time)) if with_pressure else None
    return Record.from_arrays(name="made", time=time, current=current, position=position, pressure=pressure)


@pytest.fixture(scope="module")
def made() -> tuple[Record, Fit]:
    record = record_of(nominal().with_values(spring_rate=57000.0, coulomb_friction=1250.0))
    return record, fit_base(nominal(), [experiment_of(record)])


@pytest.mark.parametrize(("record", "is_affine"), [key for key in SCALINGS if key[0] == "current, position"])
def test_no_scaling_shows_in_the_exact_simulator(record: str, is_affine: bool) -> None:
    valve = read_valve("linear" if is_affine else "calibrated")
    model = Model(valve.name, valve.values).with_values(spring_preload=0.0 if is_affine else 150.0)
    time, current = steps_and_ramps()
    before = simulate(model, time=time, current=current).position
    for scaling in SCALINGS[record, is_affine]:
        scaled = {name: model.values[name] * 1.7**power for name, power in scaling.items() if name != "static_friction"}
        after = simulate(model.with_values(**scaled), time=time, current=current).position
        assert np.abs(after - before).max() < 1e-12, scaling


def test_structure_depends_on_the_signals() -> None:
    bare, pressed = record_of(nominal()), record_of(nominal(), with_pressure=True)
    assert structure_of(bare, nominal()).measured_by["spring_rate"] == "diaphragm_area * supply_pressure"
    with_pressure = structure_of(pressed, nominal())
    assert with_pressure.measured_by["spring_rate"] == "diaphragm_area"
    assert "supply_pressure" in with_pressure.groups
    loop = Record.from_arrays(name="loop", current=bare.current[::50], position=bare.position[::50])
    settled = structure_of(loop, nominal())
    assert "viscous_friction does not enter" in settled.scalings
    assert not any("static_friction" in group for group in settled.groups)
    sticky = structure_of(bare, nominal().with_effect("static_friction"))
    assert "static_friction / (diaphragm_area * supply_pressure)" in sticky.groups


def test_choked_flow_breaks_the_scaling_of_the_supply_pressure() -> None:
    choked = nominal().with_effect("choked_flow")
    structure = structure_of(record_of(nominal()), choked)
    assert structure.signals == "current, position"
    assert structure.measured_by["spring_rate"] == "diaphragm_area"
    assert "supply_pressure" in structure.groups
    time, current = steps_and_ramps()
    before = simulate(choked, time=time, current=current).position
    for scaling in SCALINGS["current, position", False]:
        scaled = {name: choked.values[name] * 1.05**power for name, power in scaling.items() if name in choked.values}
        after = simulate(choked.with_values(**scaled), time=time, current=current).position
        assert (np.abs(after - before).max() < 1e-9) == ("supply_pressure" not in scaling), scaling


def test_sensitivity_predicts_the_change_of_the_reading(made: tuple[Record, Fit]) -> None:
    record, fit = made
    sensitivity = sensitivity_of(fit)
    names = [unknown.name for unknown in sensitivity.unknowns]
    column = sensitivity.columns[: len(record), names.index("viscous_friction")]
    grown = fit.model.with_values(viscous_friction=1.01 * fit.model.values["viscous_friction"])
    start = fit.starts[0]
    change = [
        simulate(model, time=record.time, current=record.current, start_position=start).position
        for model in (grown, fit.model)
    ]
    seen = (change[0] - change[1]) / fit.problem.experiments[0].noise
    # The start position can imitate a part of the change; the rest is what counts.
    assert np.linalg.norm(column * np.log(1.01)) == pytest.approx(np.linalg.norm(seen), rel=0.02)


def test_directions_say_what_is_not_determined(made: tuple[Record, Fit]) -> None:
    _, fit = made
    slow = np.arange(2000) * 0.5
    current = 0.012 + 0.006 * np.sin(2 * np.pi * slow / 300.0)
    run = simulate(nominal(), time=slow, current=current)
    position = run.position + NOISE * np.random.default_rng(8).standard_normal(len(slow))
    record = Record.from_arrays(name="slow", time=slow, current=current, position=position)
    quiet = fit_base(nominal(), [experiment_of(record)])
    weakest = directions_of(sensitivity_of(quiet))[0]
    assert weakest.names == ["stem_mass"]
    assert not weakest.is_determined
    assert weakest.words.startswith("stem_mass growing by 1 % would change the reading by ")
    assert weakest.words.endswith(" noise standard deviations: not determined")
    assert all(each.is_determined for each in directions_of(sensitivity_of(fit))[1:])
    account = account_of(quiet, estimates(quiet), record, has_profile=True)
    assert account.intervals["stem_mass"][0] is None or account.intervals["stem_mass"][1] is None
    assert "open" in account.open["stem_mass"]
    assert "spring_rate" not in account.open


def test_what_the_records_cannot_tell_stays_open_in_a_profile() -> None:
    time = np.arange(500) / 50.0
    current = 5e-3 + 1.2e-3 * time
    position = simulate(nominal(), time=time, current=current).position
    position = position + NOISE * np.random.default_rng(2).standard_normal(len(time))
    record = Record.from_arrays(name="rising", time=time, current=current, position=position)
    fit = fit_base(nominal(), [experiment_of(record)])
    account = account_of(fit, estimates(fit), record, has_profile=True)
    assert account.open["coulomb_friction"] == ONE_WAY
    assert "open" in account.open["stem_mass"]


def test_profile_bootstrap_and_covariance_agree_where_the_error_is_a_bowl(made: tuple[Record, Fit]) -> None:
    _, fit = made
    near = neighbourhood_of(fit)
    ends, drawn = profile(near, limits_of(fit)), bootstrap(near, 60)
    for each in estimates(fit):
        if each.name not in ("spring_rate", "coulomb_friction", "gap_gain"):
            continue
        assert each.std is not None
        assert each.interval is not None
        low, high = ends[each.name]
        assert high - low == pytest.approx(each.interval[1] - each.interval[0], rel=0.3), each.name
        assert low < each.value < high
        assert drawn[each.name][0] == pytest.approx(each.std, rel=0.4), each.name


def test_a_jagged_fit_has_no_confident_numbers_without_a_profile() -> None:
    truth = nominal().with_effect("static_friction", static_friction_ratio=1.3)
    fit = extend(fit_base(nominal(), [experiment_of(record_of(truth))]), "static_friction")
    found = estimates(fit)
    assert all(each.std is None and each.interval is None for each in found)
    assert MANY_MINIMA in {each.reason for each in found}
    sensitivity = sensitivity_of(fit)
    assert sensitivity.is_anchored
    names = [unknown.name for unknown in sensitivity.unknowns]
    # A slip moves by whole samples: the friction that starts it is seen only over a wide step.
    assert sensitivity.steps[names.index("static_friction_ratio")] > sensitivity.steps[names.index("gap_offset")]
