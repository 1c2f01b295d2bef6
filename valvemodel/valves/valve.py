"""A valve: its numbers in SI units, and where each of them came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from valvemodel.display import Card, Shown, valve_card


@dataclass(frozen=True)
class Entry:
    """A number of a valve as its file has it; `is_given` is false if it was derived or is neutral."""

    value: float
    unit: str
    source: str
    is_given: bool = True


@dataclass(frozen=True, repr=False)
class Valve(Shown):
    """The base model's numbers for one valve.

    Parameters
    ----------
    name : str
        The set, or the file without its suffix.
    values : mapping of str to float
        All base parameters by name, in SI units.
    entries : mapping of str to Entry
        The file's entries, then those that were derived from them or are neutral because nothing was given.
    what : str
        What the valve is, in a few words.
    source : str
        The file.
    """

    name: str
    values: Mapping[str, float]
    entries: Mapping[str, Entry] = field(default_factory=dict)
    what: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))
        object.__setattr__(self, "entries", MappingProxyType(dict(self.entries)))

    def _card(self) -> Card:
        return valve_card(self)
