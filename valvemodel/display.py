"""How a thing shows itself: in a notebook as a card of tables and sentences, elsewhere as the card's title."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from valvemodel.declarations import Parameter
from valvemodel.quantities import format_quantity

if TYPE_CHECKING:
    import numpy as np

    from valvemodel.model import Model
    from valvemodel.records import Record
    from valvemodel.trajectory import Trajectory
    from valvemodel.valves.valve import Valve

SIGNAL_UNITS = {"current": "A", "force": "N", "pressure": "Pa", "position": "m"}
"""Signals that a card lists, each with its SI unit."""


_LEFT = "text-align: left"
"""Notebooks put cells to the right, words too."""


@dataclass(frozen=True)
class Table:
    """Text in rows; the first cell of a row names it."""

    caption: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def html(self) -> str:
        """The table as HTML that says which cells are headings."""
        head = "".join(_cell(each, "th", "col") for each in self.headings)
        rows = "".join(
            f"<tr>{_cell(first, 'th', 'row')}{''.join(_cell(each, 'td') for each in others)}</tr>"
            for first, *others in self.rows
        )
        caption = f'<caption style="{_LEFT}">{escape(self.caption)}</caption>'
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


@dataclass(frozen=True)
class Card:
    """A title, and below it tables and sentences."""

    title: str
    parts: tuple[str | Table, ...] = ()

    @property
    def html(self) -> str:
        """The card as HTML that needs nothing from elsewhere."""
        parts = "".join(part.html if isinstance(part, Table) else f"<p>{escape(part)}</p>" for part in self.parts)
        return f"<div><p><strong>{escape(self.title)}</strong></p>{parts}</div>"


class Shown(ABC):
    """What shows itself as a card."""

    @abstractmethod
    def _card(self) -> Card:
        """Return the card."""

    def __repr__(self) -> str:
        return self._card().title

    def _repr_html_(self) -> str:
        return self._card().html


def _cell(text: str, tag: str, scope: str = "") -> str:
    says = f' scope="{scope}"' if scope else ""
    return f'<{tag}{says} style="{_LEFT}">{escape(text)}</{tag}>'


def warning_lines(warnings: Iterable[str]) -> tuple[str, ...]:
    """Return warnings as the sentences of a card."""
    return tuple(f"Warning: {each}" for each in warnings)


def record_card(record: Record) -> Card:
    """Show a record: its length, the range of its signals, what is doubtful."""
    signals = {name: getattr(record, name) for name in SIGNAL_UNITS}
    if record.position_unit == "%" and record.position is not None:
        signals["position"] = 100.0 * record.position
    title = f"Record {record.name}: {_length(record.time, len(record), 'settled pairs')}"
    return Card(title, (_ranges(signals, {"position": record.position_unit}), *warning_lines(record.warnings)))


def trajectory_card(run: Trajectory) -> Card:
    """Show a trajectory: its model, its length, the range of its signals, how long the stem stuck."""
    signals = {name: getattr(run, name) for name in ("current", "pressure", "position")}
    names = run.mode_names
    shares = (
        f"{name} {100.0 * names.count(name) / max(len(names), 1):.0f} %" for name in ("rising", "falling", "stuck")
    )
    title = f"Trajectory of {_called(run.setting.model)}: {_length(run.time, len(run), 'rows')}"
    return Card(title, (_ranges(signals), f"Share of the rows: {', '.join(shares)}."))


def model_card(model: Model) -> Card:
    """Show a model: the numbers of its valve and of its effects, each with its meaning."""
    from valvemodel.base_valve import BASE_PARAMETERS
    from valvemodel.effects import effect_of_key

    effects = {key: effect_of_key(key) for key in model.effects}
    tables = [_numbers("Valve", BASE_PARAMETERS, model.values)]
    tables += [_numbers(effect.title.capitalize(), effect.shown, model.effects[key]) for key, effect in effects.items()]
    return Card(f"Model {_called(model)}", tuple(tables))


def valve_card(valve: Valve) -> Card:
    """Show a valve: its numbers, and where each came from."""
    rows = tuple(
        (name, format_quantity(entry.value, entry.unit), entry.source) for name, entry in valve.entries.items()
    )
    title = f"Valve {valve.name}{f': {valve.what}' if valve.what else ''}"
    return Card(title, (Table("Numbers", ("number", "value", "source"), rows),))


def _numbers(caption: str, parameters: Iterable[Parameter], values: Mapping[str, float]) -> Table:
    rows = tuple(
        (each.name, format_quantity(values[each.name], each.unit), each.meaning)
        for each in parameters
        if math.isfinite(values[each.name])
    )
    return Table(caption, ("parameter", "value", "meaning"), rows)


def _ranges(signals: Mapping[str, np.ndarray | None], units: Mapping[str, str] | None = None) -> Table:
    given = {name: values for name, values in signals.items() if values is not None and len(values)}
    units = {**SIGNAL_UNITS, **(units or {})}
    rows = tuple(
        (name, *(format_quantity(float(end), units[name]) for end in (values.min(), values.max())))
        for name, values in given.items()
    )
    return Table("Signals", ("signal", "lowest", "highest"), rows)


def _length(time: np.ndarray | None, count: int, rows: str) -> str:
    if time is None:
        return f"{count} {rows}"
    return f"{count} samples over {format_quantity(float(time[-1] - time[0]), 's')}"


def _called(model: Model) -> str:
    titles = [key.replace("_", " ") for key in model.effects]
    return f"{model.name} with {', '.join(titles)}" if titles else model.name
