"""How long things take, on machines that do other things as well."""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable

LONG = 0.4
"""A measurement that has taken so long is not repeated. [s]"""


def seconds_of(work: Callable[[], object]) -> float:
    """Return the time that work takes: by the clock, or of the processor where others have kept it waiting. [s]"""
    began, began_working = time.perf_counter(), time.process_time()
    work()
    return min(time.perf_counter() - began, time.process_time() - began_working)


def shortest_time(work: Callable[[], object], repeats: int) -> float:
    """Return the shortest of several times, fewer where they are long. [s]"""
    shortest, began = float("inf"), time.perf_counter()
    for _ in range(repeats):
        shortest = min(shortest, seconds_of(work))
        if time.perf_counter() - began > LONG:
            break
    return shortest


def shortest_process(words: tuple[str, ...], repeats: int) -> dict[str, float]:
    """Return the shortest times of a process of Python with these words, by the clock and of the processor. [s]"""
    times = []
    for _ in range(repeats):
        began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *words], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        worked = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        times.append((time.perf_counter() - began, worked))
    clock, processor = (min(column) for column in zip(*times, strict=True))
    return {"seconds": clock, "processor_seconds": processor}
