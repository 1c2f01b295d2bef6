"""Cores: work in processes beside each other, and the runs of many rows in threads where cores are left over."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from multiprocessing.sharedctypes import Synchronized
from typing import Any, ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Given = ParamSpec("Given")
Answer = TypeVar("Answer")

MOST = 8
"""Cores that are used where nothing else is said."""

PARTS = 4
"""Parts of the rows for each thread: some take longer than others."""


@dataclass(frozen=True)
class Cores:
    """Cores to work on, and how many processes are at work on them just now."""

    count: int
    at_work: Synchronized[int]


_cores: list[Cores] = []
"""The cores that were opened last come last; those of a worker are its parent's."""


class Workers(ProcessPoolExecutor):
    """Processes that count those of them that are at work."""

    def submit(self, do: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        """Have a call made in one of the processes."""
        return super().submit(_work, do, *given, **named)


def _work(do: Callable[..., Any], *given: Any, **named: Any) -> Any:
    """Make a call in a worker, and say meanwhile that it is at work."""
    at_work = _cores[-1].at_work
    with at_work.get_lock():
        at_work.value += 1
    try:
        return do(*given, **named)
    finally:
        with at_work.get_lock():
            at_work.value -= 1


@contextmanager
def workers(jobs: int | None = None) -> Iterator[Executor | None]:
    """Open processes that share the compiled simulator; None where there is only one core.

    Meanwhile `in_parts` spreads its work over the cores on which none of them is at work, and linear algebra takes one:
    its threads wait for each other longer than small matrices take, where the cores are busy.
    """
    jobs = jobs or min(os.cpu_count() or 1, MOST)
    with threadpool_limits(1), nullcontext() if jobs == 1 else _forked(jobs) as pool:
        yield pool


@contextmanager
def _forked(jobs: int) -> Iterator[Executor]:
    """Open processes, forked from this one."""
    # A fork server takes 1 to 2.5 s to import the simulator. A fork beside the idle threads of polars, which read the
    # records, is safe as long as no work in here reads or writes tables: the children never call polars.
    context = get_context("fork")
    _cores.append(Cores(jobs, context.Value("i", 0)))
    pool = Workers(jobs, mp_context=context)
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        _cores.pop()


def begun(
    pool: Executor | None, do: Callable[Given, Answer], /, *given: Given.args, **named: Given.kwargs
) -> Callable[[], Answer]:
    """Begin a call in one of the processes of a pool, or make it here without one; return what gives its answer."""
    if pool is None:
        answer = do(*given, **named)
        return lambda: answer
    return pool.submit(do, *given, **named).result


def mapped(pool: Executor | None, do: Callable[..., Answer], /, *given: Iterable[Any]) -> Iterator[Answer]:
    """Make a call for each of what is given, on all cores where there is a pool; return the answers in order."""
    return (pool.map if pool else map)(do, *given)


def in_parts(do: Callable[[slice], None], rows: int) -> None:
    """Do the work of all rows, or groups of them, in threads where cores are left over: compiled code needs no lock.

    What is done with one must not depend on the others.
    """
    threads = min(_left_over(), rows)
    if threads < 2:
        do(slice(0, rows))
        return
    size = max(1, rows // (PARTS * threads))
    parts = [slice(at, min(at + size, rows)) for at in range(0, rows, size)]
    for _ in _threads(os.getpid(), _cores[-1].count).map(do, parts):
        pass


def _left_over() -> int:
    """Return how many cores this process may take: its own, and its share of those on which no process is at work."""
    if not _cores:
        return 1
    return _cores[-1].count // max(_cores[-1].at_work.value, 1)


@cache
def _threads(process: int, count: int) -> ThreadPoolExecutor:
    """Return the threads of a process; a fork of it has none of them."""
    return ThreadPoolExecutor(count)
