"""The field records: diagnosed on `a`, checked on `b` (`python -m benchmarks.field`)."""

from __future__ import annotations

import os
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np

VALVES = 6


def data_folder() -> Path:
    """Return the folder of measured records: VALVEMODEL_DATA, else beside the checkout."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    return Path(os.environ.get("VALVEMODEL_DATA", beside))


@click.command()
def main() -> None:
    """Print verdict, gap before and after on the unseen record, and seconds, for each valve."""
    from diagnosis.diagnosing import diagnose
    from identification.driving.timing import experiments_of
    from identification.experiment import Experiment
    from identification.fit import Fit
    from valvemodel.model import Model
    from valvemodel.records import read_record
    from valvemodel.valves import read_valve

    folder = data_folder() / "field"
    if not folder.is_dir():
        raise click.ClickException(f"no field records at {folder}; set VALVEMODEL_DATA")
    valve = read_valve("calibrated")

    def gap(fit: Fit, unseen: Experiment, is_anchored: bool) -> float:
        error = unseen.position - fit.simulated_on(unseen, is_anchored=is_anchored).position[0]
        return 1e3 * float(np.sqrt(np.nanmean(error**2)))

    for number in range(1, VALVES + 1):
        first, second = (read_record(folder / f"field-{number}{which}.csv") for which in "ab")
        began = time.perf_counter()
        found = diagnose([first], Model(valve.name, valve.values))
        seconds = time.perf_counter() - began
        (unseen,), _ = experiments_of([second])
        free, anchored = (
            f"{gap(found.base, unseen, each):.3f} -> {gap(found.found, unseen, each):.3f}" for each in (False, True)
        )
        causes = "; ".join(
            f"{' + '.join(cause.effects) or 'none'} {cause.probability:.2f}" for cause in found.causes[:3]
        )
        click.echo(
            f"field-{number}: {found.verdict} ({found.stage}), {causes}, unknown {found.unknown_probability:.2f}; "
            f"gap on b {free} mm free, {anchored} mm re-anchored, noise {1e3 * unseen.noise:.3f} mm; {seconds:.0f} s"
        )
        rivals = [" + ".join(each) or "none" for each in found.cause.rivals]
        if rivals:
            click.echo(f"    cannot tell from: {', '.join(rivals)}")


if __name__ == "__main__":
    main()
