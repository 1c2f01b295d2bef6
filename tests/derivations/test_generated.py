"""The generated modules: fresh, equal to the derivation in every dialect, and fit for numba."""

from pathlib import Path

import casadi as ca
import numba
import numpy as np
import pytest
import sympy as sp

import derivations
from derivations.codegen import VELOCITY_BAND
from derivations.glossary import MAGNETIC_CONSTANT, symbol
from derivations.sources import sources
from valvemodel.equations import numeric, symbolic

ROOT = Path(__file__).parents[2]
SOURCES = sources()
NAMES = [source.name for source in SOURCES]


def _points(source, count=5):
    """Random points near those of a valve: magnitudes differ, pressures stay below the supply."""
    random = np.random.default_rng(20210)
    size = {
        "P_1": 3e5,
        "P_b": 1e5,
        "S": 1e-3,
        "x": 1e-4,
        "nu": 2.0,
        "E": 7e-4,
        "i": 0.01,
        "v": 1e-4,
        "K": 1e9,
        "b_c": 0.4,
        "s_p": 0.5,
        "h_l": 0.01,
        "s_l": -4e-3 if source.name == "reading_by_position_with_slot" else 4e-3,
    }
    centre = np.array([size.get(letter, 1.0) for letter in source.letters.split()])
    return centre * random.uniform(0.5, 1.5, (count, len(centre)))


def _expected(source, point):
    values = dict(zip(source.symbols, map(sp.Float, point), strict=True))
    constants = {symbol("mu_0"): MAGNETIC_CONSTANT, symbol("epsilon"): VELOCITY_BAND}
    return float(source.closed_form.subs(values | constants))


@pytest.mark.parametrize("path", derivations.render())
def test_the_committed_file_is_fresh(path):
    assert (ROOT / path).read_text() == derivations.render()[path], "run: valvemodel derive --write"


@pytest.mark.parametrize("source", SOURCES, ids=NAMES)
def test_numeric_casadi_numba_and_sympy_agree(source):
    plain = getattr(numeric, source.name)
    compiled = numba.njit(plain)
    arguments = ca.SX.sym("arguments", len(source.symbols))
    graph = ca.Function("graph", [arguments], [getattr(symbolic, source.name)(*ca.vertsplit(arguments))])
    for point in _points(source):
        expected = pytest.approx(_expected(source, point), rel=1e-11, abs=1e-300)
        assert plain(*point) == expected
        assert compiled(*map(float, point)) == expected
        assert float(graph(point)) == expected


@pytest.mark.parametrize("source", SOURCES, ids=NAMES)
def test_arrays_go_through(source):
    points = _points(source)
    together = getattr(numeric, source.name)(*points.T)
    one_by_one = [getattr(numeric, source.name)(*point) for point in points]
    np.testing.assert_allclose(together, one_by_one, rtol=1e-14)


@pytest.mark.parametrize("source", SOURCES, ids=NAMES)
def test_casadi_matrix_symbols_go_through(source):
    arguments = ca.MX.sym("arguments", len(source.symbols))
    result = getattr(symbolic, source.name)(*ca.vertsplit(arguments))
    assert isinstance(result, ca.MX)


def test_slopes_are_the_differences():
    pressure = [numeric.static_pressure(gap, 3e5, 1e9) for gap in (29.9e-6, 30.1e-6)]
    assert np.diff(pressure)[0] / 0.2e-6 == pytest.approx(numeric.pressure_by_gap(30e-6, 3e5, 1e9), rel=1e-4)
    gap = [numeric.coil_gap(current, 126.3e-6, 750.1e-6) for current in (9.9e-3, 10.1e-3)]
    assert np.diff(gap)[0] / 0.2e-3 == pytest.approx(numeric.gap_by_current(10e-3, 750.1e-6), rel=1e-4)


def test_table_2_gives_the_flow_ratio():
    assert numeric.flow_ratio(0.75, 4.3e-4, 0.7, 1.6e-3) == pytest.approx(1.0437e9, rel=1e-4)


def test_the_band_of_the_paper_holds_a_stem_that_is_pushed():
    assert numeric.slip_acceleration_as_printed(1e5, 0.0, 1.36, 1423.0, 1.59) == 0
    assert numeric.slip_acceleration(1e5, 1e-9, 1.36, 1423.0, 1.59) > 0
