"""Several records of one valve: all of one kind, each by a name of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

from valvemodel.errors import InputError
from valvemodel.records.record import Record

_KINDS = {
    "time": "a time record",
    "loop": "a settled loop without time",
    "stem": "of the stem alone, with force instead of current",
}


def check_one_kind(records: Sequence[Record]) -> None:
    """Raise unless there is a record, and all are time records, settled loops or of the stem alone.

    Raises
    ------
    InputError
    """
    if not records:
        raise InputError("a run takes at least one record", "got none", "give one, as `read_record` reads it")
    first = records[0]
    for record in records:
        if record.kind != first.kind:
            raise InputError(
                "records of one run have one kind",
                f"{first.source or first.name} is {_KINDS[first.kind]}, "
                f"{record.source or record.name} is {_KINDS[record.kind]}",
                "give them to runs of their own",
            )


def told_apart(records: Sequence[Record]) -> list[Record]:
    """Return records each by a name of its own: of those that are named alike the second is `name (2)`.

    Examples
    --------
    >>> [each.name for each in told_apart([Record.from_arrays("day", current=[0.0])] * 3)]
    ['day', 'day (2)', 'day (3)']
    """
    taken = {record.name for record in records}
    found: list[Record] = []
    for record in records:
        if any(record.name == other.name for other in found):
            names = (f"{record.name} ({number})" for number in count(2))
            record = replace(record, name=next(name for name in names if name not in taken))
            taken.add(record.name)
        found.append(record)
    return found
