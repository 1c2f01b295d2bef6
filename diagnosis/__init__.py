"""What is missing, where and why: a diagnosis of the gap between a valve and its model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from diagnosis.diagnosing import Cause, Diagnosis, diagnose

__all__ = ["Cause", "Diagnosis", "diagnose"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'diagnosis' has no attribute {name!r}")
    from diagnosis import diagnosing

    return getattr(diagnosing, name)


def __dir__() -> list[str]:
    return sorted(__all__)
