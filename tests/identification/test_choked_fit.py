"""A blind valve whose orifices choke is explained to the noise: its gap is another than that of the law before."""

from dataclasses import replace

import numpy as np
import pytest
from blind_fits import fits_to_plant

from identification.pressures import LIGHT, pressures_at_rest, with_pressures_of
from identification.screening import screened
from identification.search import Slopes, descend
from valvemodel.effects import effect_of_key

SEED, PROFILE = 1043752039, 1758290018


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    return fits_to_plant(SEED, "choked_flow", tmp_path_factory.mktemp("choked"), profile=PROFILE, nuisance=True)


def test_choked_flow_with_another_critical_ratio_is_explained_to_the_noise(fitted):
    plant, base, found = fitted
    assert plant.effects[0].formulation == "iso_6358"
    assert base.found.error > 1.5 * base.problem.noise_error
    assert found.found.error < 1.05 * found.problem.noise_error
    ratio = found.model.effects["choked_flow"]["critical_pressure_ratio"]
    assert ratio == pytest.approx(plant.effects[0].parameters["critical_ratio"], abs=0.02)


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
