"""Drawn plants: the same from the same seed, visible, refined, and written as a record."""

from pathlib import Path

import numpy as np
import pytest

import diagnosis.blindtest.plants as plants
from diagnosis.blindtest.plants import EFFECTS, draw_plant, integrate, measure, write_record
from diagnosis.blindtest.profiles import KINDS, draw_profile

# Slips of these wait for a threshold; a step halved may move one of them by a sample.
STICK_SLIP = {"static_friction", "stribeck"}


@pytest.mark.parametrize("key", EFFECTS)
def test_every_effect_gives_a_plant_that_a_finer_step_confirms(key):
    plant = draw_plant(11, (key,))
    assert plant.answer() == (key,)
    assert plant.effects[0].unabsorbed > 1.0
    profile = draw_profile(4, duration=40.0)
    coarse, fine = (integrate(plant.base, *profile, effects=plant.effects, step=h)["position"] for h in (4e-5, 2e-5))
    difference = np.abs(coarse - fine)
    assert np.sqrt(np.mean(difference**2)) < (1e-3 if key in STICK_SLIP else 5e-6)
    assert key in STICK_SLIP or difference.max() < 2e-4


def test_same_seed_gives_the_same_record():
    first, again = (measure(draw_plant(5, ("coil_lag",)), 2, duration=20.0) for _ in range(2))
    assert all(np.array_equal(first[name], again[name]) for name in first)


def test_other_profile_seed_gives_another_record_of_the_same_valve():
    plant = draw_plant(5, ())
    first, second = (measure(plant, seed, duration=20.0) for seed in (1, 2))
    assert not np.array_equal(first["current"], second["current"])
    assert not np.array_equal(first["position"], second["position"])


def test_record_of_no_effect_is_the_base_valve_and_noise():
    plant = draw_plant(6, ())
    record = measure(plant, 1, with_pressure=True)
    true = integrate(plant.base, record["time"], record["current"], start_position=record["position"][0])
    settled = slice(2500, None)  # the start is forgotten after the first full stroke
    rms = np.std(record["position"][settled] - true["position"][settled])
    assert rms == pytest.approx(np.hypot(plant.noise, plant.resolution / np.sqrt(12)), rel=0.1)
    assert np.std(record["pressure"] - true["pressure"]) == pytest.approx(300.0, rel=0.05)


def test_pairs_and_nuisances_are_told_apart():
    plant = draw_plant(7, ("end_stop", "coil_lag"), nuisance=True)
    assert plant.answer() == ("coil_lag", "end_stop")
    hidden = [truth for truth in plant.effects if truth.nuisance]
    assert len(hidden) == 2
    assert all(truth.visibility < 0.5 for truth in hidden)
    assert plant.described()["effects"][0]["effect"] == "end_stop"


def test_what_cannot_be_made_less_than_is_noticed_is_no_nuisance():
    # The least static friction by bristles still shows with 1.7 times the noise in this valve.
    hidden = draw_plant(1103212846, (), nuisance=True).effects
    assert hidden[0].effect == "asymmetric_friction"
    assert len(hidden) == 2
    assert all(truth.visibility < 0.3 for truth in hidden)


@pytest.mark.parametrize(
    ("seed", "other"), [(30, "spring_hardening"), (30, "air_leak"), (476445546, "asymmetric_friction")]
)
def test_a_stop_is_met_beside_an_effect_that_shortens_the_travel(seed, other):
    # With the last one the stem begins lower, at rest, than where it comes to again against more friction.
    plant = draw_plant(seed, ("end_stop", other))
    _, beside = plant.effects
    profile = draw_profile(4, duration=60.0)
    free, stopped = (integrate(plant.base, *profile, effects=each)["position"] for each in ((beside,), plant.effects))
    later = slice(len(free) // 2, None)
    assert np.sqrt(np.mean((stopped - free)[later] ** 2)) > plant.noise


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_how_far_a_reading_comes_is_taken_of_the_whole_record_but_its_beginning(side):
    """It begins beyond what it reaches again, and is farthest on the other side in its last stroke."""
    trace = side * np.array([1.0, 0.9, 0.1, 0.5, 0.8, 0.2, 0.7, 0.0, 0.4])
    assert side * plants._reached(trace, side) == 0.8


def test_base_does_not_depend_on_the_effects():
    assert draw_plant(8, ("coil_lag",)).base == draw_plant(8, ("sensor_lag", "end_stop")).base


def test_a_size_at_which_the_valve_runs_away_is_too_large():
    # Its first guess at a quadratic growth of the area has no finite motion.
    (growth, *_) = draw_plant(119687888, ("area_variation",)).effects
    assert growth.parameters["change"] < 0.06
    assert 5.0 < growth.unabsorbed < 40.0


def test_unknown_and_doubled_effects_are_refused():
    with pytest.raises(ValueError, match="no effect is named rust"):
        draw_plant(1, ("rust",))
    with pytest.raises(ValueError, match="named twice"):
        draw_plant(1, ("coil_lag", "coil_lag"))


@pytest.mark.parametrize("kind", KINDS)
def test_profiles_stay_in_the_converter_range(kind):
    for seed in range(5):
        time, current = draw_profile(seed, kind=kind)
        assert time.size == current.size == 7501
        assert current.min() >= 4e-3
        assert current.max() <= 20e-3
        assert np.ptp(current) > 3e-3


def test_unknown_profile_kind_is_refused():
    with pytest.raises(ValueError, match="must be one of"):
        draw_profile(1, kind="sawtooth")


def test_record_is_written_in_the_units_of_its_header(tmp_path: Path):
    record = measure(draw_plant(9, ()), 1, duration=10.0, with_pressure=True)
    write_record(tmp_path / "record.csv", record)
    lines = (tmp_path / "record.csv").read_text().splitlines()
    assert lines[0] == "time [s],current [mA],pressure [kPa],position [mm]"
    table = np.loadtxt(lines[1:], delimiter=",")
    assert table[:, 1] == pytest.approx(record["current"] * 1e3, abs=1e-5)
    assert table[:, 3] == pytest.approx(record["position"] * 1e3, abs=1e-4)


def test_bundled_demo_is_what_its_command_makes(tmp_path: Path):
    plants.main(["--demo", str(tmp_path / "demo.csv")])
    examples = Path(plants.__file__).parents[1] / "examples"
    for name in ("demo.csv", "demo-b.csv"):
        made, kept = (np.loadtxt(folder / name, delimiter=",", skiprows=1) for folder in (tmp_path, examples))
        assert np.array_equal(made[:, :2], kept[:, :2])
        # A slip may come a sample earlier on another processor.
        assert np.mean(np.abs(made[:, 2] - kept[:, 2]) > 1.0) < 0.05
