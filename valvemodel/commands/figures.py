"""`valvemodel figures`: the paper's figures, made by the model."""

from __future__ import annotations

from pathlib import Path

import click

from valvemodel.commands.command import command
from valvemodel.commands.places import check_folder, write_together
from valvemodel.commands.waiting import progress_shown


@command(
    short_help="The paper's figures, as printed and as described.", epilog="Example: valvemodel figures --out figures"
)
@click.option(
    "--out",
    required=True,
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Folder for figure_5 and so on as PNG and SVG, and figures.json with the data behind them.",
)
def figures(out: Path) -> None:
    """Make the paper's figures anew: as its tables give them, and as its text describes them.

    \b
    Figures 5, 6  position against current, n = 1 and n = 2: Table 2 as printed, the valve set
                  `calibrated`, and the gap law that passes the two points of the text
    Figure 7      settled loop in steps of 0.5 mA with self-calibration (simulated, not measured)
    Figure 8      the method of self-calibration, eqs. (35)-(40)
    Figure 9      PID, self-calibration and SC-PID on the same set points (simulated)
    """
    check_folder(out)
    from valvemodel.paper_figures.gallery import make_figures

    with progress_shown() as progress:
        places = write_together(out, lambda folder: make_figures(folder, progress))
    click.echo(f"wrote {', '.join(str(place) for place in places.values())}", err=True)
