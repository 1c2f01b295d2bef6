"""The exact simulator against an independent fine-step integration (`python -m benchmarks.exactness`)."""

from __future__ import annotations

import time

import click
import numpy as np

DURATION, RATE = 60.0, 50.0
"""A minute of ramps and steps at the rate of the field records. [s], [Hz]"""


def ramps_and_steps(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return time [s] and current [A]: half a minute of ramps, then steps of up to 14 mA every 1.5 s."""
    clock = np.arange(round(DURATION * RATE)) / RATE
    current = np.interp(clock % 15.0, [0.0, 7.5, 15.0], [5e-3, 19.5e-3, 5e-3])
    levels = np.random.default_rng(seed).uniform(5e-3, 19e-3, 21)
    late = clock >= 0.5 * DURATION
    current[late] = levels[((clock[late] - 0.5 * DURATION) / 1.5).astype(int)]
    return clock, current


@click.command()
@click.option("--seed", default=0, show_default=True)
@click.option("--step", default=2e-6, show_default=True, help="Step of the integration. [s]")
def main(seed: int, step: float) -> None:
    """Print the largest difference in position."""
    from diagnosis.blindtest.plants import integrate
    from valvemodel.model import Model
    from valvemodel.simulation import simulate
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated")
    clock, current = ramps_and_steps(seed)
    simulate(Model(valve.name, valve.values), time=clock, current=current)
    for title, changes in (("calibrated", {}), ("f_v = 1.59 N s/m, ringing", {"viscous_friction": 1.59})):
        model = Model(valve.name, valve.values).with_values(**changes)
        began = time.perf_counter()
        exact = simulate(model, time=clock, current=current)
        middle = time.perf_counter()
        values = {name: value for name, value in model.values.items() if np.isfinite(value)}
        fine = integrate(values, clock, current, step=step)
        end = time.perf_counter()
        largest = float(np.abs(fine["position"] - exact.position).max())
        click.echo(
            f"{title}: largest difference {largest:.1e} m over {np.ptp(exact.position) * 1e3:.0f} mm of travel; "
            f"{(end - middle) / (middle - began):.0f} times faster than steps of {step:g} s"
        )


if __name__ == "__main__":
    main()
