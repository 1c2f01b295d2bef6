"""Text files of columns: encoding, separator and line ends as spreadsheets and historians write them."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import polars

from valvemodel.errors import InputError
from valvemodel.records.header import NOTHING, find_columns, read_header
from valvemodel.records.sheet import Header, Sheet

_SEPARATORS = {",": "','", ";": "';'", "\t": "tabs", "|": "'|'"}
"""In the order of preference, each as it is called in messages."""

_MOST_TITLES, _LEAST_KNOWN = 40, 2
"""Lines among which the column names are looked for, and known columns that one of them must name."""


def read_delimited(content: bytes, name: str, called: Mapping[str, Header] = NOTHING) -> Sheet:
    """Find out how a text file is written and return its columns as text.

    What known columns are called in it, where that is told, helps to find the line of their names.

    Raises
    ------
    InputError
        If the content is not text, has no line of column names, or a line has too many cells.
    """
    content, notes = _as_utf8(content, name)
    start, first_line, declared = _find_header(content, name, called)
    end = content.find(b"\n", start)
    header_line = content[start : end if end >= 0 else len(content)].decode()
    separator = declared or _separator_of(header_line, called)
    headers = tuple(read_header(cell) for cell in next(csv.reader([header_line], delimiter=separator)))
    _check_is_header(headers, name, first_line)
    if start:
        notes = (*notes, f"skipped {first_line - 1} line(s) before the column names")
    if separator != ",":
        notes = (*notes, f"read with {_SEPARATORS[separator]} between columns")
    body = _Body(content[start:].rstrip(b"\n \t" + separator.encode()), name, separator, len(headers), first_line)
    return Sheet(name, headers, body.read, body.place, notes, separator)


@dataclass(frozen=True)
class _Body:
    """The lines from the column names on, in UTF-8 with plain line ends."""

    content: bytes
    name: str
    separator: str
    width: int
    first_line: int

    def read(self, numbers: list[int]) -> list[polars.Series]:
        """Return columns as text, an empty cell as null."""
        try:
            frame = self._read(numbers, is_ragged=False)
        except polars.exceptions.PolarsError as error:
            self._check_cells(error)
            try:
                frame = self._read(numbers, is_ragged=True)
            except polars.exceptions.PolarsError as second:
                raise InputError(
                    "a text file has one cell for each column in each line",
                    f"{self.name}: {str(second).splitlines()[0]}",
                    "export it again",
                ) from None
        return [frame[name] for name in frame.columns]

    def place(self, row: int) -> str:
        """Return the line on which a row starts."""
        if b'"' not in self.content:
            return f"line {self.first_line + 1 + row}"
        for number, line, _ in self._rows():
            if number == row:
                return f"line {line}"
        return f"row {row + 1}"

    def _read(self, numbers: list[int], *, is_ragged: bool) -> polars.DataFrame:
        names = ",".join(f"c{number}" for number in range(self.width)).replace(",", self.separator)
        end = self.content.find(b"\n")
        lines = self.content[end:] if end >= 0 else b""
        frame = polars.read_csv(
            names.encode() + lines + b"\n",
            columns=[f"c{number}" for number in numbers],
            separator=self.separator,
            infer_schema=False,
            truncate_ragged_lines=is_ragged,
        )
        return frame.select(polars.col(f"c{number}").str.strip_chars() for number in numbers)

    def _check_cells(self, error: Exception) -> None:
        """Raise for the first line that has more cells than there are column names."""
        for _, line, cells in self._rows():
            if any(cell.strip() for cell in cells[self.width :]):
                raise InputError(
                    "a line has as many cells as there are column names",
                    f"{self.name}, line {line}: {len(cells)} cells, {self.width} column names",
                    "a number with a decimal comma needs ';' or a tab between columns"
                    if self.separator == ","
                    else "correct the line, or name the column",
                )
        lines = enumerate(self.content.split(b"\n"), self.first_line)
        odd = next((number for number, text in lines if text.count(b'"') % 2), None)
        if odd is not None:
            raise InputError(
                "quotes come in pairs",
                f"{self.name}, line {odd}: a quote is left open",
                "close or delete it",
            ) from error

    def _rows(self) -> Iterator[tuple[int, int, list[str]]]:
        """Yield row number, line number and cells."""
        reader = csv.reader(io.StringIO(self.content.decode(), newline=""), delimiter=self.separator)
        line = reader.line_num
        with _long_cells():
            next(reader, None)
            for number in itertools.count():
                line = self.first_line + reader.line_num
                try:
                    cells = next(reader, None)
                except csv.Error:
                    return
                if cells is None:
                    return
                yield number, line, cells


class _long_cells:  # noqa: N801
    """Let the csv module read a cell of any length, as one left open by a quote."""

    def __enter__(self) -> None:
        self.limit = csv.field_size_limit(2**31 - 1)

    def __exit__(self, *_: object) -> None:
        csv.field_size_limit(self.limit)


def _as_utf8(content: bytes, name: str) -> tuple[bytes, tuple[str, ...]]:
    """Return the content in UTF-8 with plain line ends, and what was found."""
    notes: tuple[str, ...] = ()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        content, notes = _decoded(content, "utf-16", name), ("read as UTF-16",)
    elif content[1:400:2].count(0) > 50 and not content[0:400:2].count(0):
        content, notes = _decoded(content, "utf-16-le", name), ("read as UTF-16",)
    elif content[0:400:2].count(0) > 50 and not content[1:400:2].count(0):
        content, notes = _decoded(content, "utf-16-be", name), ("read as UTF-16",)
    elif not content.isascii():
        content = content.removeprefix(b"\xef\xbb\xbf")
        try:
            content.decode("utf-8")
        except UnicodeDecodeError:
            if b"\x00" not in content:
                content, notes = content.decode("latin-1").encode(), ("read as Latin-1: it is not UTF-8",)
    if b"\x00" in content:
        raise InputError(
            "a record is a text file of columns, Parquet or MAT",
            f"{name} holds bytes that are no text",
            "export it as CSV",
        )
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return content, notes


def _decoded(content: bytes, encoding: str, name: str) -> bytes:
    try:
        return content.decode(encoding).removeprefix("\ufeff").encode()
    except UnicodeError:
        raise InputError("a text file is in one encoding", f"{name} is broken UTF-16", "save it as UTF-8") from None


def _find_header(content: bytes, name: str, called: Mapping[str, Header]) -> tuple[int, int, str | None]:
    """Return where the column names start, on which line, and the separator that a line `sep=;` declares.

    Titles may stand above them: of the first lines it is the first that names two known columns, else the first.
    """
    start, line, declared = 0, 1, None
    found: tuple[int, int, str | None] | None = None
    while start < len(content) and line <= _MOST_TITLES:
        end = content.find(b"\n", start)
        end = end if end >= 0 else len(content)
        text = content[start:end].strip()
        if text.lower().startswith(b"sep="):
            declared = text[4:].decode() or "\t"
            if declared not in _SEPARATORS:
                raise InputError(
                    "columns are separated by comma, semicolon or tab",
                    f"{name}, line {line}: {text.decode()!r}",
                    "export it again",
                )
        elif text and not text.startswith(b"#"):
            found = found or (start, line, declared)
            if _known_columns(text.decode(), declared, called) >= _LEAST_KNOWN:
                return start, line, declared
        start, line = end + 1, line + 1
    if found:
        return found
    raise InputError("a record has a line of column names", f"{name} is empty", "export it again")


def _known_columns(line: str, declared: str | None, called: Mapping[str, Header]) -> int:
    """Return how many known columns a line names."""
    cells = next(csv.reader([line], delimiter=declared or _separator_of(line, called)), [])
    return len(find_columns(tuple(map(read_header, cells)), called))


def _separator_of(line: str, called: Mapping[str, Header]) -> str:
    """Return the separator that makes the most known columns of the header line, then the most columns."""

    def columns(separator: str) -> tuple[int, int]:
        headers = tuple(map(read_header, next(csv.reader([line], delimiter=separator))))
        return len(find_columns(headers, called)), len(headers)

    return max(_SEPARATORS, key=columns)


def _check_is_header(headers: tuple, name: str, line: int) -> None:
    def is_number(text: str) -> bool:
        try:
            float(text.replace(",", "."))
        except ValueError:
            return False
        return True

    if all(is_number(header.text) for header in headers if header.text):
        raise InputError(
            "the first line names the columns with their units",
            f"{name}, line {line}: {', '.join(header.text for header in headers)[:60]!r}",
            "put a line like 'time [s],current [mA],position [mm]' on top",
        )
