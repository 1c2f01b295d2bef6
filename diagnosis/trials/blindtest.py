"""A blind test from plan to score: seal all plants, diagnose them, open them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from diagnosis.trials.answering import GIVEN, answer
from diagnosis.trials.plan import Settings, Task, tasks_of
from diagnosis.trials.scoring import Result, open_plant
from diagnosis.trials.sealing import Places, check_settings, make_plant, read_seal, seal
from diagnosis.trials.summary import summary_of
from valvemodel.files import make_folder, write_json
from valvemodel.progress import Progress, tell_nobody

SCHEMA = "valvemodel.blindtest/1"


@dataclass(frozen=True)
class BlindTest:
    """A blind test that was opened."""

    settings: Settings
    sha256: str
    results: list[Result]

    def as_json(self) -> dict[str, Any]:
        """Return the content of blindtest.json."""
        return {
            "schema": SCHEMA,
            "settings": self.settings.as_json(),
            "valve": GIVEN,
            "plants": len(self.results),
            "sealed_sha256": self.sha256,
            **summary_of(self.results),
            "results": [each.as_json() for each in self.results],
        }

    def write(self, folder: Path) -> dict[str, Path]:
        """Write blindtest.json and blindtest.html, and return their places."""
        from diagnosis.trials.page import write_page

        content = self.as_json()
        places = {name: folder / name for name in ("blindtest.json", "blindtest.html")}
        write_json(places["blindtest.json"], content)
        write_page(places["blindtest.html"], content)
        return places


def run_blindtest(
    settings: Settings,
    plants: int,
    folder: Path,
    *,
    has_baseline: bool = False,
    jobs: int = 2,
    progress: Progress = tell_nobody,
) -> BlindTest:
    """Make plants, seal their truth, diagnose their records, open and score them.

    Each plant's record, truth and answer is a file in the folder as soon as it is there: what was interrupted goes on
    where it stopped, and more plants come on top.

    Parameters
    ----------
    settings : Settings
    plants : int
    folder : Path
    has_baseline : bool
        Whether a trivial baseline answers beside the diagnosis.
    jobs : int
        Plants at the same time, each on one core.
    progress : callable
        Called with what is being done and a share of it from 0 to 1.

    Raises
    ------
    InputError
        If the folder holds another test, or a sealed truth was changed.
    """
    places, tasks = Places(make_folder(folder)), tasks_of(settings, plants)
    check_settings(places, settings)
    making = partial(make_plant, places=places, settings=settings)
    _all(making, tasks, jobs, "making plants", progress)
    whole = seal(tasks, places, settings)
    _all(partial(answer_task, places=places, has_baseline=has_baseline), tasks, jobs, "diagnosing", progress)
    opening = partial(open_plant, places=places, sealed=read_seal(places)["truths"])
    return BlindTest(settings, whole, _all(opening, tasks, jobs, "opening", progress))


def answer_task(task: Task, places: Places, has_baseline: bool) -> None:
    """Answer one plant; no truth is passed, only the place of the record and what is no candidate."""
    answer(places.record(task), places.answer(task), task.left_out, has_baseline=has_baseline)


def _all(do: Callable[[Task], Any], tasks: Sequence[Task], jobs: int, what: str, progress: Progress) -> list[Any]:
    """Do something to all tasks, some at the same time, and return what came out in their order."""
    began = time.monotonic()
    done: dict[int, Any] = {}
    progress(f"{what} 0/{len(tasks)}", 0.0)
    for number, result in (_one_by_one if jobs == 1 else partial(_at_the_same_time, jobs=jobs))(do, tasks):
        done[number] = result
        left = (time.monotonic() - began) / len(done) * (len(tasks) - len(done))
        progress(f"{what} {len(done)}/{len(tasks)}{_until(left)}", len(done) / len(tasks))
    return [done[task.number] for task in tasks]


def _one_by_one(do: Callable[[Task], Any], tasks: Sequence[Task]) -> Iterator[tuple[int, Any]]:
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        for task in tasks:
            yield task.number, do(task)


def _at_the_same_time(do: Callable[[Task], Any], tasks: Sequence[Task], jobs: int) -> Iterator[tuple[int, Any]]:
    # from a clean process: a fork of one that has read a table would wait for polars' threads for ever
    context = get_context("forkserver")
    context.set_forkserver_preload(["diagnosis.trials.blindtest"])
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_be_a_worker) as pool:
        running = {pool.submit(do, task): task.number for task in tasks}
        try:
            for each in as_completed(running):
                yield running[each], each.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _be_a_worker() -> None:
    """Use one core, and end without a word on Ctrl-C."""
    import signal

    from threadpoolctl import threadpool_limits

    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threadpool_limits(1)


def _until(seconds: float) -> str:
    return "" if seconds < 20.0 else f", {max(1, round(seconds / 60))} min to go"
