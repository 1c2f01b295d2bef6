"""How does a valve follow its set point? Controllers, closed loops on the exact valve, measures, contests."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvemodel.doors import door

if TYPE_CHECKING:
    from valvemodel.control.branches import branches_of
    from valvemodel.control.calibration import Calibration, self_calibrate
    from valvemodel.control.claims import claims_of, findings_of
    from valvemodel.control.contest import Contest, hold_contest
    from valvemodel.control.controller import Controller
    from valvemodel.control.grid import COARSE, Grid, run_grid
    from valvemodel.control.kinds import Kind, kind_of

_HOMES = {
    "COARSE": "valvemodel.control.grid",
    "Calibration": "valvemodel.control.calibration",
    "Contest": "valvemodel.control.contest",
    "Controller": "valvemodel.control.controller",
    "Grid": "valvemodel.control.grid",
    "Kind": "valvemodel.control.kinds",
    "branches_of": "valvemodel.control.branches",
    "claims_of": "valvemodel.control.claims",
    "findings_of": "valvemodel.control.claims",
    "hold_contest": "valvemodel.control.contest",
    "kind_of": "valvemodel.control.kinds",
    "run_grid": "valvemodel.control.grid",
    "self_calibrate": "valvemodel.control.calibration",
}

__all__ = [
    "COARSE",
    "Calibration",
    "Contest",
    "Controller",
    "Grid",
    "Kind",
    "branches_of",
    "claims_of",
    "findings_of",
    "hold_contest",
    "kind_of",
    "run_grid",
    "self_calibrate",
]

__getattr__, __dir__ = door(__name__, _HOMES)
