"""What a kindred fit made of the valve is taken over by name."""

from types import SimpleNamespace

import numpy as np

from identification.extending.kin import taken_over


def fit_of(**numbers: float) -> SimpleNamespace:
    unknowns = [SimpleNamespace(name=name, experiment=-1) for name in numbers]
    return SimpleNamespace(unknowns=unknowns, found=SimpleNamespace(point=np.array(list(numbers.values()))))


def test_the_order_in_which_effects_were_added_does_not_matter():
    lag = fit_of(spring_rate=1.0, start_position=2.0, sensor_time_constant=3.0)
    kin = fit_of(spring_rate=10.0, start_position=20.0, static_friction_ratio=40.0, sensor_time_constant=30.0)
    assert list(taken_over(lag, kin)) == [10.0, 20.0, 30.0]


def test_what_the_kindred_fit_does_not_move_stays():
    series = fit_of(spring_rate=1.0, load_sine=2.0, load_sine_2=3.0)
    assert list(taken_over(series, fit_of(load_sine=20.0, spring_rate=10.0))) == [10.0, 20.0, 3.0]


def test_start_positions_are_those_of_their_records():
    first, second = (SimpleNamespace(name="start_position", experiment=number) for number in (0, 1))
    fit = SimpleNamespace(unknowns=[first, second], found=SimpleNamespace(point=np.array([1.0, 2.0])))
    kin = SimpleNamespace(unknowns=[second, first], found=SimpleNamespace(point=np.array([20.0, 10.0])))
    assert list(taken_over(fit, kin)) == [10.0, 20.0]
