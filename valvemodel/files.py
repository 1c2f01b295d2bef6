"""Files are written whole or not at all: beside their place first, then renamed."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

from valvemodel.errors import InputError


def write_beside(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Write a file so that a reader sees the old file or the new one, never a part.

    `write` takes the open binary file. A link is followed; a device or pipe is written to as it is.

    Raises
    ------
    InputError
        If the folder does not exist, or the file cannot be written.
    """
    # before the link is followed: the target of /dev/stdout is no path where it is a pipe
    if os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path):
        try:
            with open(path, "wb") as file:
                write(file)
        except OSError as error:
            raise _not_written(Path(path), error) from None
        return
    path = Path(os.path.realpath(path))
    try:
        handle, beside = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise InputError(
            "an output file needs a folder that can be written",
            f"{path}: {error.strerror}",
            "make the folder or choose another place",
        ) from None
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
        os.chmod(beside, 0o644)
        os.replace(beside, path)
    except BaseException as error:
        Path(beside).unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise _not_written(path, error) from None
        raise


def _not_written(path: Path, error: OSError) -> InputError:
    # an error of polars carries its reason as text only
    reason = error.strerror or str(error)
    return InputError("an output file must be writable", f"{path}: {reason}", "make room or choose another place")


def write_text(path: Path, text: str) -> None:
    """Write text in UTF-8, as `write_beside` does.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    write_beside(path, lambda file: file.write(text.encode()))


def write_json(path: Path, content: Any) -> None:
    """Write JSON without NaN or infinity: a number that is not finite becomes null."""
    write_text(path, json.dumps(finite(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def finite(content: Any) -> Any:
    """Return the content with plain Python numbers and null for each number that is not finite."""
    if isinstance(content, dict):
        return {str(key): finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [finite(value) for value in content]
    if hasattr(content, "tolist"):
        return finite(content.tolist())
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content


def make_folder(path: Path) -> Path:
    """Make an output folder with its parents and return it."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            "the output folder must be one that can be made", f"{path}: {error.strerror}", "choose another"
        ) from None
    return path
