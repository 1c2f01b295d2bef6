"""The exact route finds valves made by independent plants from starts that are off by a factor of up to two."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.blindtest.plants import integrate
from diagnosis.blindtest.profiles import draw_profile
from diagnosis.blindtest.truth import Truth
from diagnosis.blindtest.valve import NOMINAL
from identification.exact_fit import fit_exact, forms_of
from identification.experiment import Experiment, experiment_of
from identification.fit import base_and_start_unknowns, fit_base, measured
from identification.problem import Problem
from identification.search import errors
from identification.wide import is_at_noise
from valvemodel.model import Model
from valvemodel.records import Record
from valvemodel.valves import read_valve

NOISE = 1e-4  # m
SEARCHED = ("spring_rate", "coulomb_friction", "viscous_friction", "gap_offset", "gap_gain")


def plant(seed: int, ratio: float = 1.0, **changes: float) -> tuple[dict[str, float], Experiment, Model]:
    """True numbers, a record of 100 s at 100 Hz by the independent integrator, and a model off by x0.5..x2."""
    generator = np.random.default_rng(seed)
    truth = {**NOMINAL, **changes}
    time, current = draw_profile(seed, duration=100.0, rate=100.0)
    own = {"static_excess": ratio - 1.0, "decay_speed": 1e-6}
    effects = () if ratio == 1.0 else (Truth("static_friction", "stem", "karnopp", own),)
    run = integrate(truth, time, current, effects=effects, start_share=float(generator.uniform(-0.8, 0.8)))
    position = run["position"] + NOISE * generator.standard_normal(len(time))
    record = Record.from_arrays(f"plant {seed}", time=time, current=current, position=position)
    valve = read_valve("calibrated")
    off = {name: truth[name] * float(2.0 ** generator.uniform(-1.0, 1.0)) for name in SEARCHED}
    return truth, experiment_of(record), Model("off", {**valve.values, **off})


def check(truth: dict[str, float], model: Model) -> None:
    for name in SEARCHED:
        share = 0.05 if name == "viscous_friction" else 0.02
        assert model.values[name] == pytest.approx(truth[name], rel=share), name


@pytest.mark.parametrize("seed", [10, 11])
def test_base_valve_is_found_from_no_good_start(seed: int) -> None:
    truth, experiment, model = plant(seed)
    fit = fit_base(model, [experiment])
    assert is_at_noise(fit.problem, fit.found)
    check(truth, fit.model)


def test_ringing_valve_is_found_where_descents_are_in_vain() -> None:
    truth, experiment, model = plant(3, viscous_friction=1.59)
    fit = fit_base(model, [experiment])
    assert is_at_noise(fit.problem, fit.found)
    check(truth, fit.model)


def test_static_friction_is_found_together_with_the_base() -> None:
    truth, experiment, model = plant(4, ratio=1.25)
    fit = fit_exact(model, [experiment], effects=["static_friction"])
    assert is_at_noise(fit.problem, fit.found)
    check(truth, fit.model)
    assert fit.model.effects["static_friction"]["static_friction_ratio"] == pytest.approx(1.25, rel=0.01)


def test_errors_are_those_of_the_residuals() -> None:
    _, experiment, model = plant(5)
    unknowns = base_and_start_unknowns(model, [experiment])
    generator = np.random.default_rng(6)
    points = 0.3 * generator.standard_normal((5, len(unknowns)))
    for is_anchored in (False, True):
        problem = Problem(model, [experiment], unknowns, measured([experiment]), is_anchored)
        residuals = problem.residuals(points)
        np.testing.assert_allclose(errors(problem, points), 0.5 * (residuals**2).sum(axis=1), rtol=1e-9)


def test_each_form_of_an_effect_is_searched_on_its_own() -> None:
    _, experiment, _ = plant(5)
    assert len(forms_of("static_friction", [experiment])) == 1
    forms = forms_of("stribeck", [experiment])
    laws = [{(start["stribeck_shape"], start["stribeck_tail"]) for start in form} for form in forms]
    assert laws == [{(1.0, 0.0)}, {(2.0, 0.0)}, {(2.0, 1.0)}]
