"""The kinds of controllers that are compared: what each is, where it comes from, what is tuned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from valvemodel.control.branches import Branches
from valvemodel.control.calibration import Calibration
from valvemodel.control.controller import Controller
from valvemodel.control.laws.settings import (
    BRANCH_LINE,
    HIGHEST_CURRENT,
    KNOCKER,
    LANDING,
    LOWEST_CURRENT,
    MEAN_LINE,
    MODEL_BRANCH,
    REINFORCEMENT,
    TWO_MOVES,
)
from valvemodel.control.laws.settings import PID as PID_LAW
from valvemodel.errors import unknown_name

GAIN, LENGTH, CURRENT, TIME = "gain", "length", "current", "time"


@dataclass(frozen=True)
class Tunable:
    """A setting that is tuned, on a log scale between bounds in units of the valve.

    `of` says which: the current range over the reach ("gain"), the reach, the current range, or the second.
    """

    name: str
    low: float
    high: float
    of: str

    def scale(self, branches: Branches) -> float:
        """Return the unit of the bounds for a valve. [SI]"""
        low, high = branches.reach
        span = HIGHEST_CURRENT - LOWEST_CURRENT
        return {GAIN: span / (high - low), LENGTH: high - low, CURRENT: span, TIME: 1.0}[self.of]


PROPORTIONAL = Tunable("proportional_gain", 1e-3, 2.0, GAIN)
INTEGRAL = Tunable("integral_gain", 0.05, 50.0, GAIN)
DERIVATIVE = Tunable("derivative_gain", 1e-6, 0.1, GAIN)
DEAD_BAND = Tunable("dead_band", 1e-4, 2e-2, LENGTH)
GAINS = (PROPORTIONAL, INTEGRAL, DERIVATIVE)


@dataclass(frozen=True)
class Kind:
    """A kind of controller.

    Parameters
    ----------
    key, title : str
        What files and figures call it.
    source : str
    choices : mapping
        Settings that make the kind.
    tunables : tuple of Tunable
    knows : str
        What it knows of the valve: "nothing", "calibration" or "model".
    tuned_as : str
        Key of the kind whose tuned settings it takes over; empty if it is tuned itself.
    """

    key: str
    title: str
    source: str
    choices: Mapping[str, float] = field(default_factory=dict)
    tunables: tuple[Tunable, ...] = ()
    knows: str = "nothing"
    tuned_as: str = ""

    def controller(
        self, tuned: Mapping[str, float], *, start_current: float, calibration: Calibration, branches: Branches
    ) -> Controller:
        """Return a controller of this kind with tuned settings, told no more than the kind knows."""
        settings: dict[str, float] = {"start_current": start_current, "has_anti_windup": 1.0, **self.choices}
        if self.knows == "calibration":
            settings.update(calibration.settings)
        if settings.get("law") == LANDING:
            settings["slip_jump"] = branches.slip_jump
        return Controller(self.key, {**settings, **tuned}, branches if self.knows == "model" else None)


KINDS = (
    Kind("pid", "PID", "paper (34)", tunables=GAINS),
    Kind("sc", "self-calibration alone", "paper, section 3", {"feedforward": MEAN_LINE}, (), "calibration"),
    Kind(
        "sc_pid_branch",
        "SC-PID, full width from a branch line",
        "paper (41); (40) is the full width, added at each reversal",
        {"feedforward": BRANCH_LINE},
        GAINS,
        "calibration",
    ),
    Kind(
        "sc_pid_mean",
        "SC-PID, half width from the mean line",
        "paper (41); half of (40) each way",
        {"feedforward": MEAN_LINE},
        GAINS,
        "calibration",
        tuned_as="sc_pid_branch",
    ),
    Kind(
        "sc_pid_misread",
        "SC-PID, full width from the mean line",
        "paper (41) by the letter: i +- I_threshold with the one fitted line",
        {"feedforward": MEAN_LINE, "threshold_share": 1.0},
        GAINS,
        "calibration",
    ),
    Kind(
        "sc_pid_dead_band",
        "SC-PID, half width, integral dead band",
        "paper (41) with the dead band of Åström and Hägglund",
        {"feedforward": MEAN_LINE},
        (*GAINS, DEAD_BAND),
        "calibration",
    ),
    Kind(
        "dead_band",
        "PID, integral dead band",
        "Åström and Hägglund, Advanced PID Control (2006)",
        {},
        (*GAINS, DEAD_BAND),
    ),
    Kind(
        "knocker",
        "knocker",
        "Hägglund, J. Process Control 12 (2002) 897-904",
        {"law": KNOCKER},
        (
            PROPORTIONAL,
            INTEGRAL,
            DEAD_BAND,
            Tunable("knock_amplitude", 1e-3, 0.3, CURRENT),
            Tunable("knock_width", 0.01, 0.3, TIME),
            Tunable("knock_interval", 0.05, 3.0, TIME),
        ),
    ),
    Kind(
        "reinforcement",
        "constant reinforcement",
        "Ivan and Lakshminarayanan, Ind. Eng. Chem. Res. 48 (2009) 3474-3483",
        {"law": REINFORCEMENT},
        (PROPORTIONAL, INTEGRAL, DEAD_BAND, Tunable("reinforcement", 1e-4, 0.3, CURRENT)),
    ),
    Kind(
        "two_moves",
        "two-move compensation",
        "Srinivasan and Rengaswamy, Comput. Chem. Eng. 32 (2008) 218-229; Cuadros et al. 38 (2012) 106-114",
        {"law": TWO_MOVES},
        (
            PROPORTIONAL,
            INTEGRAL,
            DEAD_BAND,
            Tunable("first_move", 1e-3, 0.3, CURRENT),
            Tunable("move_duration", 0.01, 1.0, TIME),
            Tunable("still_duration", 0.03, 3.0, TIME),
        ),
        "calibration",
    ),
    Kind(
        "scheduled",
        "gain-scheduled PI",
        "Åström and Wittenmark, Adaptive Control (1995), ch. 9; gains follow the slope of the branches",
        {"is_scheduled": 1.0},
        (PROPORTIONAL, INTEGRAL),
        "model",
    ),
    Kind(
        "inverse",
        "model's branches, PID with dead band",
        "this project; inverse of Tao and Kokotovic, Automatica 29 (1993) 323-335, with a fitted model",
        {"feedforward": MODEL_BRANCH},
        (*GAINS, DEAD_BAND),
        "model",
    ),
    Kind(
        "landing",
        "landing on the model's branches",
        "this project",
        {"law": LANDING},
        (DEAD_BAND, Tunable("dwell", 0.03, 5.0, TIME)),
        "model",
    ),
)
"""In the order in which they are shown: the paper's, then the remedies for stiction, then those with a model."""


def kind_of(key: str) -> Kind:
    """Return the kind of a key.

    Raises
    ------
    InputError
        If there is none; names the nearest.
    """
    for kind in KINDS:
        if kind.key == key:
            return kind
    raise unknown_name("a controller", key, [kind.key for kind in KINDS])


assert len({kind.key for kind in KINDS}) == len(KINDS)
assert PID_LAW == 0, "PID is the law of a record of zeros"
