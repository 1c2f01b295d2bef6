"""Batches give what single runs give, whatever the number of threads."""

import numpy as np
import pytest
from simulation_runs import EFFECT_KEYS, base_model, ramps_and_steps, run, with_effects

from valvemodel.batch import objectives, readings, rows_of
from valvemodel.errors import InputError
from valvemodel.simulation import simulate

TIME, CURRENT = ramps_and_steps(seconds=4.0)
MODELS = [with_effects(base_model(), key) for key in EFFECT_KEYS]


@pytest.mark.parametrize("key", [None, *EFFECT_KEYS])
def test_a_run_for_a_fit_is_the_traced_run_to_the_last_bit(key):
    """The quick way through a steady chain, stage by stage, and the way period by period are one."""
    model = with_effects(base_model(), key) if key else base_model()
    assert (run(model, TIME, CURRENT) == simulate(model, time=TIME, current=CURRENT).position).all()


@pytest.mark.parametrize("workers", [1, 2])
def test_readings_of_many_valves(workers):
    found = np.empty((len(MODELS), len(TIME)))
    for part, some in readings(rows_of(MODELS), time=TIME, current=CURRENT, workers=workers, at_once=5):
        found[part] = some
    for model, one in zip(MODELS, found, strict=True):
        assert (one == run(model, TIME, CURRENT)).all()


@pytest.mark.parametrize("dispersion", [0.0, 0.1])
def test_what_is_remembered_of_one_valve_is_not_taken_for_another(dispersion):
    """Behind a line a period is cut at the same place again and again, and what follows from its parts is kept."""
    bases = [base_model(viscous_friction=friction) for friction in (300.0, 612.9, 1000.0)]
    line = {"transport_delay": 0.0413, "line_dispersion": dispersion}
    models = [base.with_effect("transport_delay", **line) for base in bases]
    for part, some in readings(rows_of(models), time=TIME, current=CURRENT, workers=1, at_once=3):
        for model, one in zip(models[part], some, strict=True):
            assert (one == run(model, TIME, CURRENT)).all()


@pytest.mark.parametrize("reanchor", [None, 1.0])
def test_objectives_over_many_inputs(reanchor):
    currents = np.stack([CURRENT, CURRENT[::-1]])
    measured = np.stack([run(base_model(), TIME, current) for current in currents]) + 1e-3
    measured[0, 50:60] = np.nan
    seen = []
    sums = objectives(
        rows_of(MODELS), time=TIME, current=currents, position=measured, reanchor=reanchor, progress=seen.append
    )
    assert sum(seen) == sums.size == 2 * len(MODELS)
    for index in range(2):
        for model, total in zip(MODELS, sums[index], strict=True):
            single = simulate(model, time=TIME, current=currents[index], measured=measured[index], reanchor=reanchor)
            assert total == pytest.approx(np.nansum((single.position - measured[index]) ** 2), rel=1e-12)


def test_shapes_that_differ_are_refused():
    with pytest.raises(InputError):
        objectives(rows_of(MODELS), time=TIME, current=CURRENT, position=np.zeros(3))
