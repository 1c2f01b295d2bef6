"""What is missing, where and why: a diagnosis of the gap between a valve and its model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from diagnosis.diagnose import Cause, Diagnosis

__all__ = ["Cause", "Diagnosis"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'diagnosis' has no attribute {name!r}")
    from diagnosis import diagnose

    return getattr(diagnose, name)
