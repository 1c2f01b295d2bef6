"""A blind valve that is damped much less one way, so that it overshoots, is explained to the noise."""

from blind_fits import fits_to_plant

from identification.unknowns import base_unknowns
from valvemodel.model import Model
from valvemodel.valves import read_valve


def test_a_search_for_uneven_damping_finds_a_valve_that_overshoots_one_way():
    key = "asymmetric_viscous_friction"
    plant, base, found = fits_to_plant(1462683686, key, profile=1557603759, nuisance=True)
    damping, factor = plant.base["viscous_friction"], 1.0 + plant.effects[0].parameters["excess"]
    assert plant.effects[0].formulation == "both_sides"
    high, low = damping * factor, damping / factor**0.5
    assert base.found.error > 5.0 * base.problem.noise_error
    assert found.found.error < 1.1 * found.problem.noise_error
    assert abs(found.model.effects[key]["viscous_asymmetry"] - (high - low) / (high + low)) < 0.03


def test_the_side_to_which_slopes_promise_less_is_followed_too():
    """From the base valve alone all starts to the wrong side promise more."""
    _, base, found = fits_to_plant(63720192, "asymmetric_viscous_friction", profile=672236625, nuisance=True)
    assert base.found.error > 5.0 * base.problem.noise_error
    assert found.found.error < 1.05 * found.problem.noise_error
    assert found.model.effects["asymmetric_viscous_friction"]["viscous_asymmetry"] > 0.5


def test_damping_that_differs_thirtyfold_lies_within_reach():
    """Its mean is fifteen times what was given."""
    valve = read_valve("calibrated")
    damping = next(each for each in base_unknowns(Model(valve.name, valve.values)) if each.name == "viscous_friction")
    assert damping.value(damping.bounds[1]) > 20.0 * damping.value(0.0)
