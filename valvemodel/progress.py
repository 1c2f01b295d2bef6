"""Progress: whom long work tells what it does just now."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Called with what is being done, and a share of it from 0 to 1."""


def tell_nobody(what: str, share: float) -> None:
    """Leave untold what is being done."""
