"""Measured records: read with their units and checked, and tables of results written."""

from valvemodel.records.reading import read_record
from valvemodel.records.record import Record
from valvemodel.records.table import write_table

__all__ = ["Record", "read_record", "write_table"]
