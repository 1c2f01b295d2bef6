"""Closed loops: compiled, in plain Python, and in python-control (`python -m benchmarks.control`)."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import click
import numpy as np

PERIOD, SECONDS = 0.01, 1000.0
GAINS = {"proportional_gain": 0.02, "integral_gain": 0.2, "derivative_gain": 1e-5}
"""Of the PID, in all three. [A/m], [A/(m s)], [A s/m]"""

SHORT = 20.0
"""What python-control's nonlinear simulation is given. [s]"""


def least(work: Callable[[], object], repeats: int) -> float:
    """Return the least time that a work takes. [s]"""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return min(times)


def plain_pid(start_current: float) -> Callable[[float, float], float]:
    """Return eq. (34) as a user would write it in Python."""
    proportional, integral, derivative = (
        GAINS["proportional_gain"],
        GAINS["integral_gain"] * PERIOD,
        GAINS["derivative_gain"] / PERIOD,
    )
    total, last = 0.0, None

    def control(setpoint: float, reading: float) -> float:
        nonlocal total, last
        error = setpoint - reading
        total += error
        change = 0.0 if last is None else error - last
        last = error
        return start_current + proportional * error + integral * total + derivative * change

    return control


@click.command()
@click.option("--repeats", default=7, show_default=True)
def main(repeats: int) -> None:
    """Print the least time of each, and their ratios on the linear slipping valve."""
    from valvemodel.control.branches import branches_of
    from valvemodel.control.calibration import self_calibrate
    from valvemodel.control.kinds import KINDS
    from valvemodel.control.loop import run_compiled, run_stepped
    from valvemodel.control.scenario import held_levels
    from valvemodel.model import Model
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values).with_effect("static_friction", static_friction_ratio=1.2)
    levels = [0.12, 0.18, 0.15, 0.10, 0.20] * 20
    scenario = held_levels(levels, duration=SECONDS / len(levels), period=PERIOD, noise=1e-4)
    branches, calibration = branches_of(model), self_calibrate(model)
    slowest = 0.0
    for kind in KINDS:
        tuned = {each.name: np.sqrt(each.low * each.high) * each.scale(branches) for each in kind.tunables}
        controller = kind.controller(tuned, start_current=12e-3, calibration=calibration, branches=branches)
        taken = least(partial(run_compiled, model, controller, scenario, start_current=12e-3), repeats)
        slowest = max(slowest, taken)
        click.echo(f"{kind.title:40s} {1e3 * taken:6.1f} ms for {SECONDS:g} s at {1e3 * PERIOD:g} ms, compiled")
    stepped = least(lambda: run_stepped(model, plain_pid(12e-3), scenario, start_current=12e-3), max(repeats // 2, 1))
    click.echo(f"{'slowest compiled':40s} {1e3 * slowest:6.1f} ms")
    click.echo(f"{'PID in plain Python':40s} {stepped:6.3f} s")
    _compare_with_python_control(repeats)


def _compare_with_python_control(repeats: int) -> None:
    """Run the same PID on the same slipping valve without Coulomb friction, which is linear, in python-control."""
    from benchmarks.linear_loop import nonlinear_loop, rest_of, slipping_valve, transfer_loop
    from valvemodel.control.controller import Controller
    from valvemodel.control.loop import run_compiled
    from valvemodel.control.scenario import held_levels

    model = slipping_valve()
    levels = [rest_of(model), 0.16, 0.14, 0.15] * round(SECONDS / 40.0)
    scenario = held_levels(levels, duration=10.0, period=PERIOD)
    controller = Controller("pid", {**GAINS, "start_current": 12e-3})
    run = run_compiled(model, controller, scenario, start_current=12e-3)
    ours = least(lambda: run_compiled(model, controller, scenario, start_current=12e-3), repeats)
    answer = transfer_loop(model, GAINS, scenario)
    linear = least(lambda: transfer_loop(model, GAINS, scenario), repeats)
    short = held_levels(levels[: round(SHORT / 10.0)], duration=10.0, period=PERIOD)
    general = least(lambda: nonlinear_loop(model, GAINS, short), 1) * SECONDS / SHORT
    click.echo(
        f"the same PID on the slipping valve, {SECONDS:g} s: {1e3 * ours:.1f} ms; python-control {1e3 * linear:.0f} ms "
        f"as transfer functions ({linear / ours:.0f} times), {general:.1f} s as a NonlinearIOSystem "
        f"({general / ours:.0f} times); largest difference of position {np.abs(answer - run.position).max():.1e} m"
    )


if __name__ == "__main__":
    main()
