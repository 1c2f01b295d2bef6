"""Which numbers fit the data: experiments, unknowns, fits and what a record determines."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from identification.outcome import Outcome, fit_records

_HOMES = {"Outcome": "identification.outcome", "fit_records": "identification.outcome"}

__all__ = ["Outcome", "fit_records"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'identification' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
