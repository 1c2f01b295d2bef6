"""A blind valve whose orifices choke is explained to the noise: its gap is another than that of the law before."""

from dataclasses import replace

import numpy as np
import pytest
from blind_fits import fits_to_plant

from diagnosis.trying.candidates import freedom_of
from identification.extending.extension import extend
from identification.extending.reduction import reduced
from identification.search import Slopes, descend, descend_to_end
from identification.starting.joining import joined
from identification.starting.pressures import LIGHT, pressures_at_rest, with_pressures_of
from identification.starting.screening import screened
from valvemodel.effects import effect_of_key

SEED, PROFILE = 1043752039, 1758290018


@pytest.fixture(scope="module")
def fitted():
    return fits_to_plant(SEED, "choked_flow", profile=PROFILE, nuisance=True)


def test_choked_flow_with_another_critical_ratio_is_explained_to_the_noise(fitted):
    plant, base, found = fitted
    assert plant.effects[0].formulation == "iso_6358"
    assert base.found.error > 1.5 * base.problem.noise_error
    assert found.found.error < 1.05 * found.problem.noise_error
    ratio = found.model.effects["choked_flow"]["critical_pressure_ratio"]
    assert ratio == pytest.approx(plant.effects[0].parameters["critical_ratio"], abs=0.02)


@pytest.mark.parametrize("seed", [9608, 9617])
def test_beside_the_air_outside_the_supply_pressure_is_told_by_current_and_position(seed):
    plant, base, found = fits_to_plant(seed, "choked_flow")
    given, true = base.model.values["supply_pressure"], plant.base["supply_pressure"]
    assert plant.effects[0].formulation == "iso_6358"
    assert abs(true / given - 1.0) > 0.02
    assert found.found.error < 1.05 * found.problem.noise_error
    assert found.model.values["supply_pressure"] == pytest.approx(true, rel=4e-3)
    ratio = found.model.effects["choked_flow"]["critical_pressure_ratio"]
    assert ratio == pytest.approx(plant.effects[0].parameters["critical_ratio"], abs=2e-3)


def test_a_nozzle_by_another_law_is_explained_to_the_noise_beside_its_own_supply_pressure_only():
    """Of Saint-Venant and Wantzel; as given the pressure is off by 1.3 %."""
    plant, base, found = fits_to_plant(508495365, "choked_flow", profile=502947648, nuisance=True)
    assert plant.effects[0].formulation == "saint_venant"
    assert found.found.error < 1.05 * found.problem.noise_error
    values = dict(found.model.effects["choked_flow"])
    problem, point = joined(base.problem, found.found.point[:-2], effect_of_key("choked_flow"), values)
    assert descend_to_end(problem, point).error > 1.5 * found.found.error


def test_without_choked_flow_the_supply_pressure_is_as_it_was_given(fitted):
    _, base, found = fitted
    both = extend(found, "linkage_nonlinearity")
    assert [each.name for each in both.unknowns].count("supply_pressure") == 1
    left = reduced(both, "choked_flow")
    assert "supply_pressure" in {each.name for each in reduced(both, "linkage_nonlinearity").unknowns}
    assert "supply_pressure" not in {each.name for each in left.unknowns}
    assert left.model.values["supply_pressure"] == base.model.values["supply_pressure"]
    assert freedom_of(found) == len(found.unknowns) - len(base.unknowns) == 2


def test_a_search_begins_at_the_pressures_of_the_law_before(fitted):
    _, base, _ = fitted
    levels = np.linspace(5e-3, 19e-3, 7)
    wanted = pressures_at_rest(base.problem, base.found.point, levels)
    for trial in screened(base, effect_of_key("choked_flow")):
        begun = with_pressures_of(base.problem, base.found.point, trial.problem, trial.point)
        assert np.abs(pressures_at_rest(trial.problem, begun, levels) - wanted).max() < 10.0 * LIGHT
        assert np.abs(pressures_at_rest(trial.problem, trial.point, levels) - wanted).max() > 12.0 * LIGHT


def test_pressures_at_rest_leave_out_what_acts_in_time(fitted):
    _, base, _ = fitted
    levels = np.linspace(5e-3, 19e-3, 7)
    wanted = pressures_at_rest(base.problem, base.found.point, levels)
    drifting = base.problem.model.with_effect("gap_drift", gap_drift_rate=1e-5, gap_drift_time=25.0)
    slow = drifting.with_effect("chamber_filling", chamber_filling_time=5.0, filling_growth=0.0)
    assert pressures_at_rest(replace(base.problem, model=slow), base.found.point, levels) == pytest.approx(wanted)


def test_derivatives_of_a_search_are_renewed_or_bent_to_what_was_seen(fitted):
    _, base, _ = fitted
    problem = base.problem
    slopes = Slopes(lambda point: problem.residuals(point[None, :])[0], problem.jacobian, renewed=2)
    points = [base.found.point + share for share in (0.02, 0.015, 0.01)]
    seen = []
    for point in points:
        residual = slopes.residuals(point)
        seen.append((residual, slopes.jacobian(point), base.problem.jacobian(point)))
    for _, found, exact in seen[::2]:
        assert found == pytest.approx(exact, abs=1e-9)
    assert np.abs(seen[1][1] - seen[1][2]).max() > 1e-3
    assert seen[1][1] @ (points[1] - points[0]) == pytest.approx(seen[1][0] - seen[0][0], abs=1e-6)


def test_a_quick_look_comes_near_the_end_of_a_search(fitted):
    _, base, _ = fitted
    start = base.found.point + 0.03
    quick, exact = (descend(base.problem, start, evaluations=8, renewed=renewed) for renewed in (3, 1))
    first = 0.5 * float((base.problem.residuals(start[None, :])[0] ** 2).sum())
    assert first > 2.0 * exact.error
    assert quick.error - exact.error < 0.05 * (first - exact.error)
