"""What commands are given: a valve, records of it, effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from valvemodel.errors import InputError

if TYPE_CHECKING:
    from valvemodel.model import Model
    from valvemodel.records import Record


def complete_effects(context: click.Context, option: click.Parameter, incomplete: str) -> list[str]:
    """Return the keys of effects that begin so, for the shell."""
    from valvemodel.stages import EFFECTS

    return [effect.key for effect in EFFECTS if effect.key.startswith(incomplete)]


def complete_valves(context: click.Context, option: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the valve sets that begin so, and leave files to the shell."""
    from valvemodel.valves import valve_names

    names = [CompletionItem(name) for name in valve_names() if name.startswith(incomplete)]
    return names or [CompletionItem(incomplete, type="file")]


valve_option = click.option(
    "--valve",
    metavar="SET|FILE",
    shell_complete=complete_valves,
    help="Valve as given: a set (see `valvemodel valves`) or a file of that format.  [default: calibrated]",
)
model_option = click.option(
    "--model",
    "model_file",
    metavar="MODEL.json",
    type=click.Path(path_type=Path),
    help="A model that fit or diagnose wrote (model.json, base.json), instead of --valve.",
)
effects_option = click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="KEY[:name=value,...]",
    shell_complete=complete_effects,
    help="Switch an effect on, with values in SI units or with a unit; values that are not named are the typical "
    "ones, as `valvemodel effects KEY` shows them. May be given several times.",
)
records_argument = click.argument(
    "paths", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="RECORD..."
)
columns_option = click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="NAME=HEADER",
    help='What a column is called in the file, where that is not its name here: "current=Strom [mA]", or with the unit '
    'that it is in, "position [%]=PV". May be given several times.',
)


def model_given(valve: str | None, model_file: Path | None) -> tuple[Model, float | None]:
    """Return the model that --valve or --model names, and its rated travel [m] if the user's choice gives it.

    The valve that is taken where none was chosen says nothing of the user's travel.

    Raises
    ------
    click.UsageError
        If both are given.
    InputError
        If the valve or the model cannot be read.
    """
    if valve is not None and model_file is not None:
        raise click.UsageError("--valve and --model exclude each other: give one of them.")
    if model_file is None:
        return _valve_model(valve)
    from valvemodel.model import read_model

    model = read_model(model_file)
    return model, model.values["rated_travel"]


def base_given(valve: str | None, model_file: Path | None) -> tuple[Model, float | None]:
    """Return what `model_given` does, where that is a base valve: effects are looked for, or named for themselves.

    Raises
    ------
    InputError
        If the model has effects.
    """
    model, rated_travel = model_given(valve, model_file)
    if model.effects:
        raise InputError(
            "what is fitted or diagnosed begins with a valve without effects",
            f"{model_file} has {', '.join(model.effects)}",
            "give base.json, which diagnose writes beside model.json, or take the effects out",
        )
    return model, rated_travel


def _valve_model(name: str | None) -> tuple[Model, float | None]:
    from valvemodel.model import Model
    from valvemodel.valves import read_valve

    valve = read_valve("calibrated" if name is None else name)
    entry = valve.entries.get("rated_travel")
    travel = valve.values["rated_travel"] if name is not None and entry is not None and entry.is_given else None
    return Model(valve.name, valve.values), travel


def columns_called(texts: Sequence[str]) -> dict[str, str]:
    """Return what --column says: by the names here, with their units if told, the headers in the file.

    Raises
    ------
    InputError
        If a text is not NAME=HEADER, or a name comes twice.
    """
    from valvemodel.records.header import named_twice

    called: dict[str, str] = {}
    for text in texts:
        name, sign, header = (part.strip() for part in text.partition("="))
        if not (name and sign and header):
            raise InputError("--column is NAME=HEADER", f"got {text!r}", 'write it like --column "current=Strom [mA]"')
        if name in called:
            raise named_twice(name)
        called[name] = header
    return called


def measured_records(
    paths: Sequence[Path], model: Model, rated_travel: float | None, columns: Mapping[str, str] | None = None
) -> list[Record]:
    """Read records of one valve, all of one kind; `columns` says what those are called in the files.

    Raises
    ------
    InputError
        If one cannot be used, is given twice, or time records, settled loops and records of the stem are mixed.
    """
    from valvemodel.records import read_record
    from valvemodel.records.several import check_one_kind

    _check_each_once(paths)
    records = [_in_metres(read_record(path, rated_travel=rated_travel, columns=columns), model) for path in paths]
    check_one_kind(records)
    _check_no_copies(records)
    return records


_ONCE = "a record is given once (one is kept back to score on)"


def _check_each_once(paths: Sequence[Path]) -> None:
    seen: set[Path] = set()
    for path in paths:
        place = path.resolve()
        if place in seen:
            raise InputError(_ONCE, f"{path} came twice", "name it once")
        seen.add(place)


def _check_no_copies(records: Sequence[Record]) -> None:
    """Refuse a copy of a record under another name: what was fitted to the one would be scored on the other."""
    seen: dict[bytes, Record] = {}
    for record in records:
        signals = (record.time, record.current, record.pressure, record.position, record.force)
        content = b"".join(each.tobytes() for each in signals if each is not None)
        if content in seen:
            raise InputError(
                _ONCE,
                f"{record.source or record.name} has the same samples as {seen[content].source or seen[content].name}",
                "give another record of the valve, or this one alone",
            )
        seen[content] = record


def _in_metres(record: Record, model: Model) -> Record:
    """Return the record in metres; where percent stayed for lack of a rated travel, say how it scales."""
    if record.position_unit == "m" or record.position is None:
        return record
    travel = model.values["rated_travel"]
    note = (
        f"position is in percent and no valve with its rated_travel was given (--valve): lengths count "
        f"{1e3 * travel:g} mm as 100 %, and only their proportions mean something"
    )
    kept = tuple(each for each in record.warnings if "percent" not in each)
    return replace(record, position=record.position * travel, position_unit="m", warnings=(*kept, note))


def with_effects(model: Model, texts: Sequence[str]) -> tuple[Model, list[str]]:
    """Switch on the effects that were given as KEY or KEY:name=value,name=value.

    Returns
    -------
    (Model, list of str)
        The model, and for each effect a line that says which typical values were taken, if any.

    Raises
    ------
    InputError
        If an effect or a parameter is unknown, or an effect comes twice.
    """
    from valvemodel.effects import effect_of_key, parse_effect
    from valvemodel.quantities import format_quantity

    given: set[str] = set()
    notes = []
    for text in texts:
        key, values = parse_effect(text)
        if key in given:
            raise InputError("an effect is given once", f"{key} came twice", "put all its values into one")
        given.add(key)
        values = {**model.effects.get(key, {}), **values}
        model = model.with_effect(key, **values)
        taken = [
            f"{each.name} {format_quantity(model.effects[key][each.name], each.unit)}"
            for each in effect_of_key(key).shown
            if each.name not in values
        ]
        if taken:
            notes.append(f"{key} at typical values: {', '.join(taken)}")
    return model, notes
