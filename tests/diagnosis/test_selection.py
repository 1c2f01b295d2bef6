"""What is tried: stand-ins make room for what they stand in for."""

from types import SimpleNamespace

import pytest

from diagnosis.judgement import differ_by_aliases
from diagnosis.selection import exchanged
from diagnosis.trying import Candidate


def candidate(misfit: float, *effects: str) -> Candidate:
    return Candidate(effects, "+".join(effects), SimpleNamespace(misfit=misfit))


def test_effects_of_the_best_pair_are_exchanged_for_their_aliases():
    keys = ("sensor_lag", "magnetic_saturation", "choked_flow", "coil_lag", "static_friction", "load_force")
    alone = [candidate(9.0, key) for key in keys]
    pair = candidate(2.0, "magnetic_saturation", "sensor_lag")
    work = exchanged([candidate(20.0), *alone, pair], {key: {} for key in keys})
    causes = {frozenset(each.effects): each for each in work}
    assert set(causes) == {
        frozenset(("choked_flow", "sensor_lag")),
        frozenset(("magnetic_saturation", "coil_lag")),
    }
    # The effect that stays is fitted alone, the other comes on top of it.
    assert all(each.fit == each.effects[0] for each in work)
    assert causes[frozenset(("choked_flow", "sensor_lag"))].effects == ("sensor_lag", "choked_flow")


def test_no_pair_is_exchanged_for_one_that_was_tried():
    keys = ("sensor_lag", "magnetic_saturation", "choked_flow")
    tried = [candidate(20.0), *(candidate(9.0, key) for key in keys)]
    tried += [candidate(2.0, "magnetic_saturation", "sensor_lag"), candidate(3.0, "choked_flow", "sensor_lag")]
    assert exchanged(tried, {key: {} for key in keys}) == []


@pytest.mark.parametrize(
    ("effects", "others", "expected"),
    [
        (("coil_lag",), ("sensor_lag",), True),
        (("coil_lag",), ("end_stop",), False),
        (("coil_lag", "end_stop"), ("end_stop", "sensor_lag"), True),
        (("coil_lag", "end_stop"), ("sensor_lag", "magnetic_saturation"), False),
        ((), ("linkage_backlash",), True),
        ((), ("coil_lag",), False),
        (("coil_lag", "linkage_backlash"), ("coil_lag",), True),
    ],
)
def test_causes_that_differ_by_aliases(effects, others, expected):
    assert differ_by_aliases(effects, others) == expected
    assert differ_by_aliases(others, effects) == expected
