"""A blind valve with a slow transmitter is explained to the noise, whether it lags once or twice."""

import pytest

from diagnosis.blindtest.plants import draw_plant, measure, write_record
from identification.extension import extend
from identification.fit import fit_base
from identification.holdout import hold_out
from identification.timing import experiments_of
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.valves import read_valve


@pytest.mark.parametrize(("seed", "order"), [(9302, "first_order"), (9306, "second_order"), (9314, "second_order")])
def test_lag_of_either_order_is_explained_to_the_noise(seed, order, tmp_path):
    plant = draw_plant(seed, ("sensor_lag",))
    assert plant.effects[0].formulation == order
    path = tmp_path / "record.csv"
    write_record(path, measure(plant, seed + 7))
    experiments, _ = experiments_of([read_record(path)])
    holdout = hold_out(experiments)
    valve = read_valve("calibrated")
    base = fit_base(Model(valve.name, valve.values), holdout.experiments, holdout.fitted)
    found = extend(base, "sensor_lag")
    assert base.found.error > 4.0 * base.problem.noise_error
    assert found.found.error < 1.15 * found.problem.noise_error
    numbers = found.model.effects["sensor_lag"]
    total = numbers["sensor_time_constant"] + numbers["sensor_second_time_constant"]
    assert total == pytest.approx(plant.effects[0].parameters["time_constant"], rel=0.05)
