"""All peers on all workloads: for each the cheapest setting that gets six digits, then its time and digits."""

from __future__ import annotations

import importlib
import io
import os
import tokenize
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath as mp
import numpy as np

from benchmarks.simulation import ours
from benchmarks.simulation.stopwatch import seconds_of, shortest_time
from benchmarks.simulation.truth import DIGITS, exact_positions, loop_pressures
from benchmarks.simulation.workload import STEMS, Stem, steps, triangle

PEERS = (
    "plain_python", "scipy_events", "pathsim_events", "casadi_events", "scikit_sundae", "siconos_stepping",
    "diffrax_loop",
)  # fmt: skip

ENOUGH = 6.0
"""Digits that a peer's setting must get."""

LOST = 3.0
"""Fewer digits than these mean that an event was lost: a missed jump is 2 % of the travel."""

SECONDS = 4.0
"""A peer runs on as many periods as it gets through in about this time, all of them if it can. [s]"""

REPEATS = 40

SHORT = 0.05
"""A run that is shorter is repeated. [s]"""


@dataclass(frozen=True)
class Workload:
    """Pressures on a stem and the positions that they give, in 50 digits, with and without the stop-speed rule."""

    stem_name: str
    title: str
    pressures: np.ndarray
    exact: list[mp.mpf]
    exact_without_rule: list[mp.mpf]

    @property
    def stem(self) -> Stem:
        """The stem."""
        return STEMS[self.stem_name]

    def digits(self, positions: np.ndarray, exact: list[mp.mpf]) -> float:
        """Return the correct digits of the first positions: -log10 of the largest error over the travel."""
        with mp.workdps(DIGITS):
            travel = max(exact) - min(exact)
            pairs = zip(positions.tolist(), exact, strict=False)
            worst = max(abs(mp.mpf(found) - true) if np.isfinite(found) else mp.inf for found, true in pairs)
            return max(float(-mp.log10(worst / travel)) if worst else 17.0, 0.0)

    def best_digits(self, positions: np.ndarray) -> float:
        """Return the digits against the solution with or without the rule, whichever are more."""
        return max(self.digits(positions, self.exact), self.digits(positions, self.exact_without_rule))


def workloads(periods: int) -> Iterator[Workload]:
    """Yield the workloads: each stem under a triangle, random steps and in closed loop."""
    for name, stem in STEMS.items():
        for title, pressures in (
            ("triangle", triangle(periods)),
            ("steps", steps(periods)),
            ("closed loop", np.array(loop_pressures(stem, periods))),
        ):
            held = pressures.tolist()
            exact, without = (exact_positions(stem, held, has_rule=has_rule) for has_rule in (True, False))
            yield Workload(name, title, pressures, exact, without)


def time_ours(workload: Workload) -> dict[str, Any]:
    """Return digits and time of the toolkit; it follows the rule, and so does its truth."""
    run = ours.stem_run(workload.stem, workload.pressures)
    positions = run()
    return {
        **named(workload),
        "peer": "valvemodel",
        "digits": workload.digits(positions, workload.exact),
        "us_per_period": 1e6 * shortest_time(run, REPEATS) / len(workload.pressures),
        "periods": len(workload.pressures),
        "setting": "default",
        "loses_events": False,
    }


def time_peer(peer: ModuleType, workload: Workload, stretch: int) -> dict[str, Any]:
    """Return digits and time of a peer at the first setting that gets enough digits, else at its best."""
    tried = []
    for setting in peer.SETTINGS:
        found = measure(peer, workload, setting, stretch)
        tried.append(found)
        if found["digits"] >= ENOUGH:
            affordable = SECONDS / (1e-6 * found["us_per_period"])
            periods = len(workload.pressures) if affordable > len(workload.pressures) else int(affordable)
            if periods > stretch:
                found = measure(peer, workload, setting, periods)
                tried.append(found)
            if found["digits"] >= ENOUGH:
                return found
    return max(tried, key=lambda found: found["digits"])


def measure(peer: ModuleType, workload: Workload, setting: Any, periods: int) -> dict[str, Any]:
    """Return digits and time of a peer at a setting on the first periods; a peer that breaks off has no digits."""
    pressures = workload.pressures[:periods]
    positions = np.full(periods, np.nan)

    def run() -> None:
        nonlocal positions
        # What a peer raises where it cannot go on; what it got through is no answer.
        with suppress(RuntimeError, ValueError, ArithmeticError):
            positions = peer.run(workload.stem, pressures, setting)

    with silenced():
        getattr(peer, "prepare", lambda *_: None)(workload.stem, pressures, setting)
        seconds = seconds_of(run)
        if seconds < SHORT:
            seconds = min(seconds, shortest_time(run, 5))
    digits = workload.best_digits(positions)
    return {
        **named(workload),
        "digits": digits,
        "us_per_period": 1e6 * seconds / periods,
        "periods": periods,
        "setting": setting if isinstance(setting, str) else " ".join(str(part) for part in setting),
        "loses_events": digits < LOST,
    }


def named(workload: Workload) -> dict[str, Any]:
    """Return what a workload is called."""
    return {"stem": workload.stem_name, "workload": workload.title}


def installed_peers() -> tuple[dict[str, ModuleType], list[str]]:
    """Return the peers by name, and the names of those that are not installed."""
    found, missing = {}, []
    for name in PEERS:
        try:
            found[name] = importlib.import_module(f"benchmarks.simulation.peers.{name}")
        except ImportError:
            missing.append(name)
    return found, missing


def code_lines(path: Path) -> int:
    """Return the lines of code of a file: no blank lines, comments, docstrings or imports."""
    lines: set[int] = set()
    tokens = [
        token
        for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline)
        if token.type not in (tokenize.COMMENT, tokenize.NL, tokenize.INDENT, tokenize.DEDENT)
    ]
    starts_line = True
    is_skipped = False
    for token in tokens:
        if starts_line:
            is_skipped = token.type == tokenize.STRING or token.string in ("import", "from")
        starts_line = token.type == tokenize.NEWLINE
        if not is_skipped and token.type not in (tokenize.NEWLINE, tokenize.ENDMARKER):
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines)


@contextmanager
def silenced() -> Iterator[None]:
    """Send what compiled libraries print to nowhere."""
    null = os.open(os.devnull, os.O_WRONLY)
    kept = [os.dup(stream) for stream in (1, 2)]
    try:
        for stream in (1, 2):
            os.dup2(null, stream)
        yield
    finally:
        for stream, saved in zip((1, 2), kept, strict=True):
            os.dup2(saved, stream)
            os.close(saved)
        os.close(null)
