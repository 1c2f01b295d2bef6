"""The smooth route of the fit: success from far starts, time, bias by width (`python -m benchmarks.smooth_route`)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click
import numpy as np

if TYPE_CHECKING:
    from identification.experiment import Experiment
    from identification.fit import Fit
    from identification.smooth_fit import Smoothing
    from valvemodel.model import Model

DURATION, RATE, NOISE = 100.0, 100.0, 1e-4
"""The record of the figures to reach. [s], [Hz], [m]"""

FACTOR = 2.0
"""Starts are off by up to this factor either way."""

SHARE, DEVIATIONS = 0.02, 3.0
"""A parameter is found within 2 %, or within three of its own standard deviations."""

FREE = ("spring_rate", "coulomb_friction", "viscous_friction", "gap_offset", "gap_gain")


def record(model: Model, seed: int, step: float) -> Experiment:
    """Return ramps and steps on the valve, by the blind plants' own integration, with noise."""
    from diagnosis.blindtest.plants import integrate
    from identification.experiment import experiment_of
    from valvemodel.records import Record

    generator = np.random.default_rng(seed)
    clock = np.arange(round(DURATION * RATE)) / RATE
    ramps = np.interp(clock % 20.0, [0.0, 10.0, 20.0], [5e-3, 19.5e-3, 5e-3])
    steps = np.repeat(generator.uniform(5e-3, 19e-3, round(DURATION)), round(RATE))
    current = np.where(clock < 0.5 * DURATION, ramps, steps)
    values = {name: value for name, value in model.values.items() if np.isfinite(value)}
    position = integrate(values, clock, current, step=step)["position"]
    noisy = position + NOISE * generator.standard_normal(len(clock))
    return experiment_of(Record.from_arrays(name="plant", time=clock, current=current, position=noisy))


def far_start(model: Model, seed: int) -> Model:
    """Return the valve with each free parameter off by a random factor."""
    generator = np.random.default_rng(seed)
    return model.with_values(**{name: model.values[name] * FACTOR ** generator.uniform(-1.0, 1.0) for name in FREE})


def misses(fit: Fit, truth: Model) -> list[str]:
    """Return the parameters that are neither within the share nor within their own deviations."""
    from identification.determined.uncertainty import estimates

    missed = []
    for each in estimates(fit):
        error = abs(each.value - truth.values[each.name])
        within = DEVIATIONS * each.std if each.std is not None else 0.0
        if each.name in FREE and error > max(SHARE * truth.values[each.name], within):
            missed.append(each.name)
    return missed


@click.command()
@click.option("--starts", default=30, show_default=True)
@click.option("--damping", default=612.9, show_default=True, help="Viscous friction of the valve. [N s/m]")
@click.option("--multiple", is_flag=True, help="By multiple shooting with IPOPT.")
@click.option("--step", default=1e-5, show_default=True, help="Step of the plant's integration. [s]")
def main(starts: int, damping: float, multiple: bool, step: float) -> None:
    """Print success, time and what smoothing did."""
    from identification.smooth_fit import fit_smooth
    from valvemodel.model import Model
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated")
    truth = Model(valve.name, valve.values).with_values(viscous_friction=damping)
    experiment = record(truth, 0, step)
    seconds, clean, missed = [], [0, 0], []
    for seed in range(starts):
        began, burnt = time.perf_counter(), time.process_time()
        fitted = fit_smooth([experiment], far_start(truth, seed), is_multiple=multiple)
        seconds.append((time.perf_counter() - began, time.process_time() - burnt))
        for number, fit in enumerate((fitted.smooth, fitted.fit)):
            clean[number] += not misses(fit, truth)
        missed += misses(fitted.smooth, truth)
    elapsed, processor = np.median(seconds, axis=0)
    click.echo(
        f"f_v = {damping:g} N s/m: found {clean[0]} of {starts} smooth, {clean[1]} of {starts} after the exact refit; "
        f"{elapsed:.1f} s elapsed, {processor:.1f} s of processor, median, after import"
    )
    if missed:
        click.echo(f"missed: {', '.join(sorted(set(missed)))}")
    print_bias(fitted.smoothing, truth)


def print_bias(smoothing: Sequence[Smoothing], truth: Model) -> None:
    """Print, by width, how far smoothing moved the trajectory and each parameter of the last fit."""
    click.echo("width     rms        max        " + "  ".join(f"{name:>17s}" for name in FREE))
    for each in smoothing:
        shifts = "  ".join(f"{100.0 * each.shifts[name] / truth.values[name]:+16.4f}%" for name in FREE)
        click.echo(f"{each.width:5g} N  {1e3 * each.rms:.4f} mm  {1e3 * each.largest:.4f} mm  {shifts}")


if __name__ == "__main__":
    main()
