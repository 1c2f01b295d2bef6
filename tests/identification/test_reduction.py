"""What is left of a cause without one of its effects goes on from where it is."""

import numpy as np
import pytest
from blind_fits import fits_to_plant

from identification.extending.extension import extend, extend_from
from identification.extending.reduction import reduced

KEY = "linkage_nonlinearity"


@pytest.fixture(scope="module")
def fits():
    _, base, found = fits_to_plant(9306, KEY)
    return base, found


def test_without_the_effect_that_was_added_last_the_fit_is_what_it_was(fits):
    _, found = fits
    back = reduced(extend(found, "coil_lag"), "coil_lag")
    assert list(back.model.effects) == [KEY]
    assert [each.name for each in back.unknowns] == [each.name for each in found.unknowns]
    assert back.found.error == pytest.approx(found.found.error, rel=1e-3)
    assert back.model.numbers == pytest.approx(found.model.numbers, rel=0.05, abs=1e-3)


def test_the_others_are_fitted_anew_from_their_values_beside_it(fits):
    """Without the bent linkage a leak is as good as nothing, and the base valve is what it was without either."""
    base, found = fits
    back = reduced(extend_from(found, "air_leak", {"leak_ratio": 0.03, "turbulent_leak_ratio": 0.02}), KEY)
    assert list(back.model.effects) == ["air_leak"]
    assert len(back.found.point) == len(back.unknowns) == len(base.unknowns) + 2
    assert np.all(np.isfinite(back.found.point))
    assert back.found.error < 1.02 * base.found.error


def test_only_an_effect_that_is_there_can_be_taken_out(fits):
    with pytest.raises(KeyError, match="no effect 'coil_lag' in the fit, only linkage_nonlinearity"):
        reduced(fits[1], "coil_lag")
