"""Off a tight spot, and off stops that give way, a stem glides in closed form: against an independent integration."""

import numpy as np
import pytest
from independent_chain import IndependentChain
from simulation_runs import base_model, ramps_and_steps, run, with_effects

from identification.problem import SEARCH_TOLERANCE
from valvemodel.trajectory import TOLERANCE

TIME, CURRENT = ramps_and_steps(seconds=4.0, seed=2)


BELLS = [(2e-3, 2.0), (8e-3, 2.0), (8e-3, 6.0), (4e-2, 3.0)]
SHARP = [(8e-3, 1.0), (8e-3, 1.4), (4e-2, 40.0)]
ENDING = [(8e-3, 2.0, 0.4), (8e-3, 1.0, 1.0), (2e-2, 2.0, 1.0), (4e-2, 40.0, 0.7), (6e-3, 2.0, -0.5)]
BESIDE = [(), ("chamber_filling",), ("static_friction",), ("asymmetric_friction",)]


@pytest.mark.parametrize(
    ("width", "exponent", "closure", "beside"),
    [
        *((*spot, 0.0, keys) for spot in BELLS for keys in BESIDE),
        *((*spot, 0.0, ()) for spot in SHARP),
        *((*spot, ()) for spot in ENDING),
    ],
)
def test_run_past_a_tight_spot_is_within_its_tolerance(width, exponent, closure, beside):
    spot = {"tight_spot_excess": 0.6, "tight_spot_position": 0.13, "tight_spot_closure": closure}
    model = with_effects(base_model(), *beside)
    clear = run(model, TIME, CURRENT)
    model = model.with_effect(
        "position_dependent_friction", **spot, tight_spot_width=width, tight_spot_exponent=exponent
    )
    expected = IndependentChain.of(model).run(TIME, CURRENT)
    assert np.abs(expected - clear).max() > 1e-4
    for tolerance, bound in ((TOLERANCE, 1e-9), (SEARCH_TOLERANCE, 1e-4)):
        assert np.abs(run(model, TIME, CURRENT, tolerance=tolerance) - expected).max() < bound


def test_tight_spot_and_yielding_stops_together_are_met_where_they_are():
    stops = {"upper_stop": 0.16, "lower_stop": 0.08, "stop_compliance": 2e-7}
    spot = {"tight_spot_excess": 0.6, "tight_spot_position": 0.158, "tight_spot_width": 5e-3}
    model = base_model().with_effect("end_stop", **stops).with_effect("position_dependent_friction", **spot)
    expected = IndependentChain.of(model).run(TIME, CURRENT)
    assert expected.max() > 0.16
    assert np.abs(run(model, TIME, CURRENT) - expected).max() < 1e-9
