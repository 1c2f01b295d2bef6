"""A blind valve with a slow transmitter is explained to the noise, whether it lags once or twice."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from blind_fits import base_of_plant, fits_to_plant

from identification.extending.extension import Extension, extend, extend_from
from identification.extending.pairs import traces_of
from identification.extending.restart import begun_again
from identification.extending.sluggishness import traded
from identification.search import Found
from identification.starting.screening import screened
from identification.unknowns import Unknown
from valvemodel.effects import effect_of_key


@pytest.mark.parametrize(("seed", "order"), [(9302, "first_order"), (9306, "second_order"), (9314, "second_order")])
def test_lag_of_either_order_is_explained_to_the_noise(seed, order):
    plant, base, found = fits_to_plant(seed, "sensor_lag")
    assert plant.effects[0].formulation == order
    assert base.found.error > 4.0 * base.problem.noise_error
    assert found.found.error < 1.15 * found.problem.noise_error
    numbers = found.model.effects["sensor_lag"]
    total = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert total == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.05)


def test_a_second_lag_is_found_where_the_base_valve_made_up_for_the_first_by_mass_and_damping():
    seed, profile = 1785193381, 946444716
    plant, base, found = fits_to_plant(seed, "sensor_lag", profile=profile, nuisance=True)
    assert plant.effects[0].formulation == "second_order"
    assert base.model.values["stem_mass"] > 5.0 * plant.base["stem_mass"]
    assert found.found.error < 1.05 * found.problem.noise_error
    numbers = found.model.effects["sensor_lag"]
    lag = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert lag == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.01)


def test_a_lag_is_found_from_a_sluggish_base_valve_and_from_beside_another_effect():
    """The base valve overshoots nowhere; from there a search had ended above 20, from the mass as given at 31."""
    seed, profile = 1506728585, 827035033
    plant, base, found = fits_to_plant(seed, "sensor_lag", profile=profile, nuisance=True)
    assert found.found.error < 1.05 * found.problem.noise_error
    beside = extend(found, "asymmetric_viscous_friction")
    assert beside.found.error < 1.05 * beside.problem.noise_error
    again = extend(base, "sensor_lag", Extension(known=dict(beside.model.effects["sensor_lag"]), kin=beside))
    assert again.found.error < 1.05 * again.problem.noise_error
    numbers = again.model.effects["sensor_lag"]
    lag = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert lag == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.01)


@pytest.mark.parametrize(
    ("seed", "profile", "other", "left", "off"),
    [(487619353, 1602509984, "end_stop", 1.1, 0.03), (1835734096, 163837514, "presliding", 1.4, 0.1)],
)
def test_a_lag_beside_another_effect_takes_over_what_friction_and_mass_made_up_for(seed, profile, other, left, off):
    """A search had ended beside a lag of a twentieth, and of a fifth, of the true one; to the last, it begins again.

    Beside bristles a hair decides whether it ends at the noise before that.
    """
    plant, base = base_of_plant(seed, (other, "sensor_lag"), profile=profile, nuisance=True)
    (truth,) = (each for each in plant.effects if each.effect == "sensor_lag")
    beside = extend(extend(base, other), "sensor_lag")
    for found, most, far in ((beside, left, off), (begun_again(beside), 1.1, 0.03)):
        assert found.found.error < most * found.problem.noise_error
        numbers = found.model.effects["sensor_lag"]
        lag = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
        assert lag == pytest.approx(truth.parameters["time_constant"], rel=far)


def test_only_too_much_friction_stands_in_for_a_lag_and_only_for_one():
    friction, rate = Unknown("viscous_friction", "N*s/m", 600.0, 600.0, True, 50.0, 7e3), 5e4
    others = [
        Unknown("spring_rate", "N/m", rate, rate, True, 1e4, 1e5),
        Unknown("stem_mass", "kg", 1.4, 1.4, True, 0.1, 17.0),
    ]
    for excess, is_traded in ((1.0, True), (0.3, False), (-1.0, False)):
        point = np.array([excess, 0.0, 2.5])
        fit = SimpleNamespace(unknowns=[friction, *others], found=Found(point, 1.0))
        starts = traded(fit, effect_of_key("coil_lag"), [(("lag_behind_core", 1.0),)])
        assert len(starts) == is_traded
        assert traded(fit, effect_of_key("gap_drift"), [()]) == []
        if not starts:
            continue
        ((values, move),) = starts
        valve = dict(zip(("friction", "rate", "mass"), point + move, strict=True))
        spared = 600.0 * (math.exp(excess) - math.exp(valve["friction"]))
        assert values.pop("coil_time_constant") == pytest.approx(spared / rate)
        assert values == {"eddy_time_constant": 0.0, "lag_behind_core": 1.0}
        # It overshoots.
        assert valve["rate"] == 0.0
        assert 600.0 * math.exp(valve["friction"]) < 2.0 * math.sqrt(rate * 1.4 * math.exp(valve["mass"]))


def test_a_flux_that_lags_behind_its_core_is_told_from_a_current_that_lags_before_it():
    _, base = base_of_plant(1311547896, ("magnetic_hysteresis", "coil_lag"), profile=1932089513, nuisance=True)
    found = extend(extend(base, "magnetic_hysteresis"), "coil_lag")
    assert found.found.error < 1.05 * found.problem.noise_error
    assert found.model.effects["coil_lag"]["lag_behind_core"] == 1.0
    first = extend_from(
        extend(base, "magnetic_hysteresis"),
        "coil_lag",
        {"coil_time_constant": 0.04, "eddy_time_constant": 0.0, "lag_behind_core": 0.0},
    )
    assert first.found.error > 3.0 * first.problem.noise_error


def test_without_a_core_that_bends_a_lag_has_one_order():
    _, base = base_of_plant(9302, ("sensor_lag",))
    lag = effect_of_key("coil_lag")
    orders = [trial.problem.model.effects["coil_lag"]["lag_behind_core"] for trial in screened(base, lag)]
    assert orders == [0.0] * len(orders)
    assert len(orders) == 4
    assert {trace.values["lag_behind_core"] for trace in traces_of(base, lag)} == {0.0}


def test_a_line_that_smears_is_found_from_one_that_does_not():
    """A search that stood at no lag had stayed there, with half as much mass again, and left 1.14 of the noise."""
    plant, _, found = fits_to_plant(430206229, "transport_delay", profile=1152079594, nuisance=True)
    truth = plant.effects[0]
    assert truth.formulation == "dispersive_line"
    assert found.found.error < 1.03 * found.problem.noise_error
    numbers = found.model.effects["transport_delay"]
    assert numbers["transport_delay"] == pytest.approx(truth.parameters["delay"], rel=0.01)
    assert numbers["line_dispersion"] == pytest.approx(truth.parameters["dispersion"], rel=0.1)
