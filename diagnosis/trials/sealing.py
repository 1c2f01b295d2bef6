"""The seal: each plant's truth is written, and its hash, before any diagnosis starts; opening checks the hash."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from diagnosis.blindtest.plants import Plant, Truth, draw_plant, measure, write_record
from diagnosis.trials.plan import Settings, Task
from valvemodel.errors import InputError
from valvemodel.files import make_folder, write_json, write_text

SCHEMA = "valvemodel.seal/1"


@dataclass(frozen=True)
class Places:
    """Where the files of a blind test lie."""

    folder: Path

    @property
    def seal(self) -> Path:
        """The hashes of all truths."""
        return self.folder / "seal.json"

    def answer(self, task: Task) -> Path:
        """What the diagnosis wrote of a plant."""
        return self.folder / "answers" / task.name

    def record(self, task: Task) -> Path:
        """All that the diagnosis sees of a plant."""
        return self.folder / "records" / f"{task.name}.csv"

    def truth(self, task: Task) -> Path:
        """What is really in it."""
        return self.folder / "sealed" / f"{task.name}.json"


def make_plant(task: Task, places: Places, settings: Settings) -> None:
    """Draw a plant, take its record and write its truth, unless that was done before."""
    if places.truth(task).exists():
        return
    plant = draw_plant(task.seeds["plant"], task.effects, nuisance=True)
    record, truth = places.record(task), places.truth(task)
    make_folder(record.parent)
    make_folder(truth.parent)
    beside = record.with_suffix(".unfinished")
    measured = measure(plant, task.seeds["record"], with_pressure=settings.with_pressure)
    if settings.current_noise > 0.0:
        noise = settings.current_noise * np.random.default_rng(task.seeds["record"]).standard_normal(
            len(measured["current"])
        )
        measured["current"] = np.maximum(measured["current"] + noise, 0.0)
    write_record(beside, {name: values[:: settings.every] for name, values in measured.items()})
    os.replace(beside, record)
    content = {"plant": plant.described(), "kind": task.kind, "seeds": task.seeds, "record_sha256": hash_of(record)}
    write_text(truth, json.dumps(content, indent=1) + "\n")


def seal(tasks: Sequence[Task], places: Places, settings: Settings) -> str:
    """Write the hash of each truth that has none yet, and one over all of them, which it returns.

    Raises
    ------
    InputError
        If the folder holds the seal of a test with other settings.
    """
    check_settings(places, settings)
    before = read_seal(places)["truths"] if places.seal.exists() else {}
    hashes = before | {task.name: hash_of(places.truth(task)) for task in tasks if task.name not in before}
    whole = hash_of_all(hashes)
    write_json(places.seal, {"schema": SCHEMA, "settings": settings.as_json(), "sha256": whole, "truths": hashes})
    return whole


def check_settings(places: Places, settings: Settings) -> None:
    """Refuse a folder that holds another test."""
    if not places.seal.exists():
        return
    before = Settings().as_json() | read_seal(places)["settings"]
    if before != settings.as_json():
        changed = [name for name, value in settings.as_json().items() if before.get(name) != value]
        raise InputError(
            "a folder holds one blind test",
            f"{places.folder} holds one with another {' and '.join(changed)}",
            "choose another with --out",
        )


def read_seal(places: Places) -> dict[str, Any]:
    """Return the content of seal.json."""
    try:
        content = json.loads(places.seal.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(
            "the seal must be readable", f"{places.seal}: {error}", "start anew in another folder"
        ) from None
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise InputError(f"a seal has the schema {SCHEMA!r}", f"{places.seal} has not", "start anew in another folder")
    return content


def open_truth(task: Task, places: Places, sealed: dict[str, str]) -> Plant:
    """Open a plant's truth.

    Raises
    ------
    InputError
        If truth or record is not what was sealed.
    """
    path = places.truth(task)
    if sealed.get(task.name) != hash_of(path):
        raise _broken(path)
    content = json.loads(path.read_text(encoding="utf-8"))
    if content["record_sha256"] != hash_of(places.record(task)):
        raise _broken(places.record(task))
    plant = content["plant"]
    return Plant(**{**plant, "effects": tuple(Truth(**truth) for truth in plant["effects"])})


def _broken(path: Path) -> InputError:
    return InputError(
        "a sealed file must not change before it is opened", f"{path} was changed", "start anew in another folder"
    )


def hash_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def hash_of_all(hashes: dict[str, str]) -> str:
    """Return the SHA-256 over lines of name and hash, in the order of the names."""
    lines = "".join(f"{name} {digest}\n" for name, digest in sorted(hashes.items()))
    return hashlib.sha256(lines.encode()).hexdigest()
