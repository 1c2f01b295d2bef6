"""The workshop in which causes are tried: what they are scored on, the processes that help, and who is told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, TypeVar

from identification.cores import mapped
from identification.holdout import Holdout
from valvemodel.progress import Progress, tell_nobody

Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Workshop:
    """Where causes are tried.

    Attributes
    ----------
    holdout : Holdout
        What they are fitted to and scored on. Work that is done in another process takes it along, not the workshop.
    pool : Executor or None
        Processes beside this one, if there are any.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.
    """

    holdout: Holdout
    pool: Executor | None = None
    progress: Progress = tell_nobody

    def map(self, do: Callable[..., Answer], *given: Iterable[Any]) -> Iterator[Answer]:
        """Make a call for each of what is given, on all cores where there is a pool; return the answers in order."""
        return mapped(self.pool, do, *given)
