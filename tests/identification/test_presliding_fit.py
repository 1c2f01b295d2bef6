"""A blind valve that gives way before it slides is explained to the noise, whichever law it follows."""

import pytest

from diagnosis.blindtest.plants import draw_plant, measure, write_record
from identification.extension import extend
from identification.fit import fit_base
from identification.holdout import hold_out
from identification.timing import experiments_of
from valvemodel.model import Model
from valvemodel.records import read_record
from valvemodel.valves import read_valve


@pytest.mark.parametrize(("seed", "law"), [(9001, "lugre"), (9019, "dahl"), (9000, "iwan")])
def test_presliding_of_every_law_is_explained_to_the_noise(seed, law, tmp_path):
    plant = draw_plant(seed, ("presliding",))
    assert plant.effects[0].formulation == law
    path = tmp_path / "record.csv"
    write_record(path, measure(plant, seed + 7))
    experiments, _ = experiments_of([read_record(path)])
    holdout = hold_out(experiments)
    valve = read_valve("calibrated")
    base = fit_base(Model(valve.name, valve.values), holdout.experiments, holdout.fitted)
    found = extend(base, "presliding")
    assert base.found.error > 10.0 * base.problem.noise_error
    assert found.found.error < 1.15 * found.problem.noise_error
    compliance = found.model.effects["presliding"]["presliding_compliance"]
    assert compliance == pytest.approx(plant.effects[0].parameters["compliance"], rel=0.2)
