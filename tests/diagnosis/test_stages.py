"""The stage of an unknown cause is judged by what resembles it, stand-ins included."""

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis.judging.judgement import Judgement
from diagnosis.judging.stages import open_stages, resemblance, stage_probabilities
from diagnosis.trying.candidates import Candidate
from valvemodel.stages import EFFECTS


def candidate(misfit: float, *effects: str, step: float = 0.0) -> Candidate:
    readings = np.random.default_rng(0).uniform(0.0, 0.1, 2000)
    readings = step * np.round(readings / step) if step else readings
    problem = SimpleNamespace(experiments=[SimpleNamespace(position=readings, noise=1e-4)])
    return Candidate(effects, SimpleNamespace(problem=problem), SimpleNamespace(misfit=misfit))


def test_what_fell_short_hints_at_its_stage_and_more_at_those_of_its_aliases():
    tried = [candidate(50.0), candidate(5.0, "asymmetric_viscous_friction"), candidate(49.0, "choked_flow")]
    hints = resemblance(tried)
    assert sum(hints.values()) == pytest.approx(1.0)
    # What looks like it elsewhere is an asymmetric filling.
    assert sorted(hints, key=lambda stage: -hints[stage])[:2] == ["nozzle", "stem"]


def test_a_hint_at_the_aliases_is_shared_by_their_stages():
    hints = resemblance([candidate(50.0), candidate(5.0, "sensor_lag"), candidate(6.0, "coil_lag")])
    # Each of the two lags fell short and stands in for the other, or for what lies between them.
    assert sorted(hints, key=lambda stage: -hints[stage]) == ["nozzle", "electromagnet", "sensor", "stem"]
    assert hints["sensor"] > 0.15 > 0.1 > hints["stem"]


def test_what_looks_like_it_in_its_own_stage_is_hinted_at_too():
    # A filling that is the same both ways, or a lag elsewhere, or a supply that sags.
    hints = resemblance([candidate(50.0), candidate(5.0, "asymmetric_filling")])
    assert max(hints, key=lambda stage: hints[stage]) == "nozzle"


def test_a_load_in_waves_says_nothing_of_where():
    near = [candidate(50.0), candidate(40.0, "position_dependent_friction")]
    waves = replace(candidate(5.0, "load_force"), has_series=True)
    assert resemblance([*near, waves]) == resemblance(near)


def test_what_hardly_helps_says_little_beside_what_comes_near():
    tried = [candidate(50.0), candidate(5.0, "asymmetric_viscous_friction")]
    many = [candidate(30.0, key) for key in ("load_force", "gap_drift", "supply_droop", "friction_drift")]
    alone, among = resemblance(tried), resemblance([*tried, *many])
    assert among == pytest.approx(alone, abs=1e-3)


def test_where_nothing_helps_stages_count_by_the_effects_known_in_them():
    hints = resemblance([candidate(50.0), candidate(60.0, "load_force")])
    known = Counter(effect.stage for effect in EFFECTS)
    assert hints == pytest.approx({stage: count / len(EFFECTS) for stage, count in known.items()})


def test_probabilities_of_the_stages_and_of_no_effect_sum_to_one():
    tried = [candidate(9.0), candidate(2.0, "coil_lag"), candidate(1.5, "coil_lag", "end_stop")]
    shares = stage_probabilities("effect", tried, Judgement(np.array([0.1, 0.3, 0.4]), 0.2, np.zeros(3)))
    assert sum(shares.values()) == pytest.approx(0.9)
    assert shares["electromagnet"] > 0.5 > shares["stem"] >= 0.2


def test_likeness_that_one_effect_declares_holds_for_both():
    # Presliding declares that it looks like play of the linkage, not the other way round.
    hints = resemblance([candidate(50.0), candidate(5.0, "linkage_backlash")])
    assert hints["stem"] > hints["sensor"]


def test_where_the_cause_is_unknown_the_nearest_ones_do_not_speak_for_their_own_stage():
    tried = [candidate(50.0), candidate(4.0, "magnetic_hysteresis"), candidate(4.1, "spring_hardening")]
    judgement = Judgement(np.array([0.0, 0.05, 0.35]), 0.6, np.zeros(3))
    assert stage_probabilities("unknown", tried, judgement) == pytest.approx(resemblance(tried))
    assert stage_probabilities("effect", tried, judgement)["stem"] > 0.35


def test_where_a_pressure_was_measured_resemblance_is_asked_within_each_half():
    # Where a lag of the coil fell short, the nozzle lags rather.
    tried = [candidate(50.0), candidate(20.0, "position_dependent_friction"), candidate(40.0, "coil_lag")]
    judgement = Judgement(np.zeros(3), 1.0, np.zeros(3))
    halves = [(("electromagnet", "nozzle"), 0.9), (("stem", "sensor"), 0.1)]
    shares = stage_probabilities("unknown", tried, judgement, halves)
    assert shares["electromagnet"] + shares["nozzle"] == pytest.approx(0.9)
    assert shares["nozzle"] > shares["electromagnet"]
    assert stage_probabilities("unknown", tried, judgement)["stem"] > 0.5


def test_stages_left_open():
    shares = {"electromagnet": 0.3, "nozzle": 0.1, "stem": 0.5, "sensor": 0.1}
    assert open_stages("unknown", shares, [("load_force",)]) == ["stem", "electromagnet"]
    assert open_stages("effect", shares, [("coil_lag",), ("sensor_lag",)]) == ["electromagnet", "sensor"]
    assert open_stages("none", shares, []) == []
    # An effect that hides in the base, and was no candidate.
    assert open_stages("none", shares, [("linkage_backlash",)]) == ["sensor"]


@pytest.mark.parametrize(("step", "is_named"), [(0.0, False), (5e-5, False), (4e-3, True)])
def test_coarse_steps_of_the_readings_hint_at_the_sensor_by_what_they_leave(step, is_named):
    # Steps of 4 mm leave 133 times the square of the noise.
    hints = resemblance([candidate(134.0, step=step), candidate(100.0, "stribeck")])
    assert (max(hints, key=lambda stage: hints[stage]) == "sensor") == is_named


def test_coarse_steps_hint_at_little_where_they_leave_little():
    hints = resemblance([candidate(4000.0, step=4e-3), candidate(2000.0, "stribeck")])
    assert max(hints, key=lambda stage: hints[stage]) == "stem"
