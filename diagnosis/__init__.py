"""What is missing, where and why: a diagnosis of the gap between a valve and its model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvemodel.doors import door

if TYPE_CHECKING:
    from diagnosis.by_kind import diagnose
    from diagnosis.causes import Cause
    from diagnosis.valve_diagnosis import Diagnosis

_HOMES = {
    "Cause": "diagnosis.causes",
    "Diagnosis": "diagnosis.valve_diagnosis",
    "diagnose": "diagnosis.by_kind",
}

__all__ = ["Cause", "Diagnosis", "diagnose"]

__getattr__, __dir__ = door(__name__, _HOMES)
