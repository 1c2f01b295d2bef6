"""A blind valve whose orifices choke is explained to the noise: its gap is another than that of the law before."""

import numpy as np
import pytest
from blind_fits import fits_to_plant

from identification.extension import screened
from identification.pressures import LIGHT, pressures_at_rest, with_pressures_of
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
