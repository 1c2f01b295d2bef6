"""What the signals determine: scalings leave every relation as it is, and the groups are the design's."""

import numpy as np
import pytest
import sympy as sp

from derivations.glossary import symbol
from derivations.symmetries import RECORDS, groups, relations, scalings
from valvemodel.equations.symmetries import GROUPS, SCALINGS

KINDS = [(record, is_affine) for record in RECORDS for is_affine in (False, True)]


@pytest.mark.parametrize(("record", "is_affine"), KINDS)
def test_a_scaling_changes_no_relation(record, is_affine):
    factor = sp.Symbol("factor", positive=True)
    for powers in scalings(record, is_affine=is_affine):
        scaled = {symbol(letter): factor**power * symbol(letter) for letter, power in powers.items()}
        for relation in relations(record, is_affine=is_affine):
            assert sp.simplify(relation.subs(scaled, simultaneous=True) - relation) == 0, (powers, relation)


@pytest.mark.parametrize(("record", "is_affine"), KINDS)
def test_what_no_scaling_moves_is_seen(record, is_affine):
    """The count of groups is the rank of the relations' derivatives at many random signals, found by other means."""
    generator = np.random.default_rng(7)
    names = sorted({letter for each in groups(record, is_affine=is_affine) for letter in each})
    names += sorted({letter for each in scalings(record, is_affine=is_affine) for letter in each} - set(names))
    numbers = [symbol(letter) for letter in names]
    at = {number: sp.Float(generator.uniform(0.5, 1.5), 60) for number in numbers}
    rows = []
    for relation in relations(record, is_affine=is_affine):
        slopes = [sp.diff(relation, number).subs(at) for number in numbers]
        for _ in range(8):
            signals = {each: sp.Float(generator.uniform(0.1, 0.9), 60) for each in sp.Tuple(*slopes).free_symbols}
            rows.append([sp.N(slope.subs(signals), 60) for slope in slopes])
    sizes = np.linalg.svd(np.array(rows, float), compute_uv=False)
    assert int((sizes > 1e-11 * sizes[0]).sum()) == len(groups(record, is_affine=is_affine))


def test_only_ratios_enter_current_and_position():
    found = groups("current, position")
    for letter in ("k", "F_c", "F_s", "f_v", "m"):
        assert {letter: 1, "S_1": -1, "P_1": -1} in found
    assert {"c_0": 1, "K": sp.Rational(1, 2)} in found
    assert {"E": 1, "K": sp.Rational(1, 2)} in found
    assert {"P_1": 1} in groups("current, pressure, position")
    assert {"m": 1} in groups("force, position")


def test_table_holds_what_was_derived():
    assert set(SCALINGS) == set(GROUPS) == set(KINDS)
    force = SCALINGS["current, position", False][1]
    assert force["spring_rate"] == force["stem_mass"] == force["diaphragm_area"] == 1.0
