"""How much time controllers leave on the table, beside the least time of each move (`python -m benchmarks.moves`)."""

from __future__ import annotations

import math

import click
import numpy as np

COMPARED = ("pid", "sc_pid_branch", "landing")


@click.command()
@click.option("--effect-ratio", default=1.2, show_default=True, help="F_s/F_c of the valve set `calibrated`.")
@click.option("--rate", default=math.inf, show_default=True, help="Greatest rate of the least-time current. [mA/s]")
def main(effect_ratio: float, rate: float) -> None:
    """Print, for each step of the contest, the settling time of each controller and the least time."""
    from valvemodel.control.contest import hold_contest
    from valvemodel.control.kinds import KINDS
    from valvemodel.control.measures import BAND_SHARE
    from valvemodel.control.optimal_move import least_time
    from valvemodel.model import Model
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated")
    model = Model(valve.name, valve.values).with_effect("static_friction", static_friction_ratio=effect_ratio)
    contest = hold_contest(model, noise=0.0, kinds=[kind for kind in KINDS if kind.key in COMPARED])
    band = BAND_SHARE * valve.values["rated_travel"]
    entries = {key: contest.entry(key) for key in COMPARED}
    run = entries["sc_pid_branch"].run
    left: dict[str, list[float]] = {key: [] for key in COMPARED}
    for number, part in enumerate(contest.scenario.steps[1:], 1):
        before, target = part.start - 1, float(run.setpoint[part.start])
        move = least_time(
            model,
            start_current=float(run.current[before]),
            start_position=float(run.position[before]),
            target=target,
            rate=rate * 1e-3,
            band=band,
        )
        settled = {key: entries[key].steps[number].settling_time for key in COMPARED}
        for key, seconds in settled.items():
            left[key].append(seconds - move.duration)
        told = ", ".join(f"{key} {'never' if math.isinf(t) else f'{t:.2f} s'}" for key, t in settled.items())
        click.echo(
            f"{1e3 * run.position[before]:6.1f} -> {1e3 * target:6.1f} mm: least {move.duration:.2f} s "
            f"(overshoot {1e3 * move.overshoot:.3f} mm); {told}"
        )
    for key, times in left.items():
        finite = [each for each in times if math.isfinite(each)]
        median = f"median {np.median(finite):.2f} s" if finite else "none settles"
        click.echo(f"{key}: {median} above the least time; {len(times) - len(finite)} of {len(times)} never settle")


if __name__ == "__main__":
    main()
