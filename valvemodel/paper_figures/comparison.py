"""Figure 9: PID, self-calibration and SC-PID on the same set points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from valvemodel.control.contest import Contest, hold_contest
from valvemodel.control.contest_json import contest_json
from valvemodel.control.kinds import KINDS
from valvemodel.control.tuning import BUDGET
from valvemodel.drawing import BLUE, GREEN, INK, VERMILLION
from valvemodel.model import Model
from valvemodel.progress import Progress
from valvemodel.valves import read_valve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COMPARED = {"pid": VERMILLION, "sc": GREEN, "sc_pid_mean": BLUE}
"""The three of the paper, SC-PID with half the width each way."""

EFFECTS: dict[str, dict[str, float]] = {"static_friction": {"static_friction_ratio": 1.2}}
"""With F_s = F_c, as (33) has it, no stem jumps."""

DEVIATION = 20.0
"""That the lower axes show. [mm]"""


def compare(progress: Progress) -> Contest:
    """Tune the three alike and run them on `calibrated` with breakaway friction.

    Beside them runs what one of them takes its tuning from.
    """
    valve = read_valve("calibrated")
    needed = {*COMPARED, *(kind.tuned_as for kind in KINDS if kind.key in COMPARED)}
    kinds = [kind for kind in KINDS if kind.key in needed]
    return hold_contest(Model(valve.name, valve.values, EFFECTS), kinds=kinds, budget=BUDGET, progress=progress)


def draw_comparison(figure: Figure, contest: Contest) -> None:
    """Draw the three courses on one axis, and each deviation on its own."""
    whole, *own = figure.subplots(1 + len(COMPARED), 1, sharex=True, height_ratios=[3.0, 1.0, 1.0, 1.0])
    scenario = contest.scenario
    time = scenario.time
    whole.plot(time, 1e3 * scenario.setpoint, color=INK, linestyle="--", linewidth=1.0, label="set point")
    for axes, (key, colour) in zip(own, COMPARED.items(), strict=True):
        entry = contest.entry(key)
        position = entry.run.position
        whole.plot(time, 1e3 * position, color=colour, linewidth=1.3, label=entry.kind.title)
        axes.plot(time, 1e3 * (position - scenario.setpoint), color=colour, linewidth=1.1)
        axes.axhline(0.0, color=INK, linewidth=0.8)
        axes.set_ylim(-DEVIATION, DEVIATION)
        axes.set_title(_words(entry), fontsize=9)
    own[1].set_ylabel("position less set point [mm]")
    whole.set_ylabel("position [mm]")
    whole.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.12))
    own[-1].set_xlabel("time [s]")
    figure.suptitle(
        "Figure 9, simulated: three controllers, tuned alike on other set points; `calibrated`, F_s/F_c = 1.2"
    )


def _words(entry: Any) -> str:
    measured = entry.overall
    return (
        f"{entry.kind.title}: {100.0 * measured['settled_share']:.0f} % of the set points settled, "
        f"{measured['reversals']:.0f} reversals"
    )


def comparison_json(contest: Contest) -> dict[str, Any]:
    """Return the data behind the figure."""
    content = contest_json(contest)
    content["courses"] = {
        "time": {"value": contest.scenario.time, "unit": "s"},
        "setpoint": {"value": contest.scenario.setpoint, "unit": "m"},
        **{key: {"value": contest.entry(key).run.position, "unit": "m"} for key in COMPARED},
    }
    return content
