"""Several records of one valve: all of one kind."""

from __future__ import annotations

from collections.abc import Sequence

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
