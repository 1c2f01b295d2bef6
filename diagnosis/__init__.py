"""What is missing, where and why: a diagnosis of the gap between a valve and its model."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from diagnosis.by_kind import diagnose
    from diagnosis.diagnosing import Cause, Diagnosis

_HOMES = {"Cause": "diagnosis.diagnosing", "Diagnosis": "diagnosis.diagnosing", "diagnose": "diagnosis.by_kind"}

__all__ = ["Cause", "Diagnosis", "diagnose"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'diagnosis' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
