"""Work on many items in threads, which the compiled loops let run at the same time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from threading import Event
from typing import Any

WORKERS = 2


def side_by_side(
    work: Callable[[Any, Callable[[], None]], Any], items: Sequence[Any], report: Callable[[float], None]
) -> list[Any]:
    """Return the results of a work on each item, in order.

    Parameters
    ----------
    work : callable
        Takes an item and a function to call now and then, which raises where the work has been interrupted.
    items : sequence
    report : callable
        Told the share that is done.
    """
    is_interrupted = Event()

    def go_on() -> None:
        if is_interrupted.is_set():
            raise CancelledError

    found = []
    executor = ThreadPoolExecutor(WORKERS)
    try:
        for result in executor.map(lambda item: work(item, go_on), items):
            found.append(result)
            report(len(found) / len(items))
    finally:
        is_interrupted.set()
        executor.shutdown(cancel_futures=True)
    return found
