"""Where results go: checked before the work begins, written together when it is done."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from valvemodel.errors import InputError
from valvemodel.files import make_folder


def check_folder(folder: Path) -> None:
    """Refuse a folder that could not be made or written, without making it.

    Raises
    ------
    InputError
        If it is a file, lies under one, or may not be written.
    """
    nearest = folder
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    rule, remedy = "the output folder must be one that can be made and written", "choose another with --out"
    if not nearest.is_dir():
        raise InputError(rule, f"{nearest} is a file", remedy)
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise InputError(rule, f"{nearest} may not be written", remedy)


def check_file(path: Path, option: str = "--out") -> None:
    """Refuse an output file that could not be written, without writing it.

    Raises
    ------
    InputError
        If it is a folder, or its folder does not exist or may not be written.
    """
    rule, remedy = "an output file needs a folder that can be written", f"choose another place with {option}"
    if path.is_dir():
        raise InputError(rule, f"{path} is a folder", f"name a file in it with {option}")
    if path.exists() and not path.is_file():
        return
    if not path.parent.is_dir():
        raise InputError(rule, f"{path.parent} is no folder", f"make it or choose another place with {option}")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise InputError(rule, f"{path.parent} may not be written", remedy)


def check_not_input(out: Path, given: Mapping[str, Path | str | None], option: str = "--out") -> None:
    """Refuse an output file, named by an option, that is an input too; inputs by the option that named them.

    Raises
    ------
    InputError
        If they are the same file, by whatever name.
    """
    for source, path in given.items():
        if path is not None and os.path.isfile(path) and os.path.exists(out) and os.path.samefile(path, out):
            raise InputError(
                f"{option} is another file than {source}",
                f"{out} is the file that {source} names, {path}",
                f"choose another place with {option}",
            )


def write_together(folder: Path, write: Callable[[Path], dict[str, Path]]) -> dict[str, Path]:
    """Write several files into a folder, all or, where `write` fails, none of them.

    Parameters
    ----------
    folder : Path
        Made where it does not exist.
    write : callable
        Takes a folder, writes files into it and returns their places by name.

    Returns
    -------
    dict
        The places in `folder` by name.
    """
    made = _missing(folder)
    make_folder(folder)
    try:
        beside = Path(tempfile.mkdtemp(dir=folder, prefix=".unfinished."))
    except OSError as error:
        raise InputError(
            "the output folder must be one that can be written",
            f"{folder}: {error.strerror}",
            "choose another",
        ) from None
    is_done = False
    try:
        written = write(beside)
        places = {name: folder / place.relative_to(beside) for name, place in written.items()}
        for name, place in places.items():
            os.replace(written[name], place)
        is_done = True
        return places
    finally:
        shutil.rmtree(beside, ignore_errors=True)
        if not is_done:
            _remove_empty(made)


def _missing(folder: Path) -> list[Path]:
    """Return the folders that are to be made, the innermost first."""
    missing = []
    while not folder.exists() and folder != folder.parent:
        missing.append(folder)
        folder = folder.parent
    return missing


def _remove_empty(folders: list[Path]) -> None:
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return
