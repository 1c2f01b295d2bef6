"""Which numbers fit the data: experiments, unknowns, fits and what a record determines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvemodel.doors import door

if TYPE_CHECKING:
    from identification.fitting import fit_records
    from identification.results.outcome import Outcome

_HOMES = {"Outcome": "identification.results.outcome", "fit_records": "identification.fitting"}

__all__ = ["Outcome", "fit_records"]

__getattr__, __dir__ = door(__name__, _HOMES)
