"""Units are read, not guessed."""

import contextlib
import doctest
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from valvemodel import quantities
from valvemodel.base_valve import BASE_PARAMETERS
from valvemodel.errors import InputError
from valvemodel.quantities import format_quantity, parse_quantity, scale_of, to_si


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("28.15 mm", "m", 0.02815),
        ("28.15mm", "m", 0.02815),
        ("-1.5e2 N", "N", -150.0),
        ("210 kPa", "Pa", 210e3),
        ("2.1 barg", "Pa", 210e3),
        ("12 mA", "A", 0.012),
        ("750.1 um/sqrt(A)", "m/A^0.5", 750.1e-6),
        ("10.625 kPa/mA", "Pa/A", 1.0625e7),
        ("612.9 N s/m", "N*s/m", 612.9),
        ("612.9 kg/s", "N*s/m", 612.9),
        ("1e9 m^-2", "1/m^2", 1e9),
        ("1.4", "1", 1.4),
        ("140 %", "1", 1.4),
        ("1.4", "", 1.4),
        ("0 m", "m", 0.0),
        ("0e-999999999999 m", "m", 0.0),
    ],
)
def test_quantity_is_read(text, unit, value):
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("28.15", "m", 'write it like "28.15 mm"'),
        ("28,15 mm", "m", "the decimal sign is a point"),
        ("mm", "m", "a quantity is a number and its unit"),
        ("", "m", "a quantity is a number and its unit"),
        ("1e999 m", "m", "finite"),
        ("nan m", "m", "a quantity is a number"),
        ("4 MM", "m", "did you mean mm"),
        ("4 kPa", "m", "something else"),
        ("4 furlongs per", "m", "not a unit"),
        ("4 m^9^9^9^9", "m", "not a unit"),
        ("4 __import__('os')", "m", "not a unit"),
        ("3 bara", "Pa", "absolute"),
        ("5 degC", "K", "offset"),
        ("1 N*s", "1", "something else"),
    ],
)
def test_what_is_no_quantity_is_refused_with_a_remedy(text, unit, words):
    with pytest.raises(InputError) as error:
        parse_quantity(text, unit)
    assert words in str(error.value)


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text):
    with contextlib.suppress(InputError):
        assert math.isfinite(parse_quantity(text, "m"))


@pytest.mark.parametrize("parameter", BASE_PARAMETERS, ids=lambda parameter: parameter.name)
def test_units_of_the_base_valve_are_si(parameter):
    assert scale_of(parameter.unit, parameter.unit) == (1.0, 1.0)


def test_arrays_keep_their_shape():
    np.testing.assert_array_equal(to_si(np.array([[4, 20]]), "mA", "A"), [[0.004, 0.020]])


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.02815, "m", "28.15 mm"),
        (1e-6, "m", "1 um"),
        (210276.5, "Pa", "210.3 kPa"),
        (0.0125, "A", "12.5 mA"),
        (1423.0, "N", "1423 N"),
        (1.0437e9, "1/m^2", "1.044e9 1/m^2"),
        (1.4, "1", "1.4"),
        (0.0, "m", "0 mm"),
        (math.inf, "m", "none"),
        (None, "m", "not determined"),
        (math.nan, "N", "not determined"),
    ],
)
def test_quantity_is_shown_as_engineers_write_it(value, unit, text):
    assert format_quantity(value, unit) == text


def test_examples_hold():
    assert doctest.testmod(quantities).failed == 0
