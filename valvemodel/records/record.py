"""A record: the signals of one valve over one run, in SI units."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from valvemodel.display import Card, Shown, record_card
from valvemodel.errors import InputError
from valvemodel.plots import Plotted

if TYPE_CHECKING:
    import pandas

Signal = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Record(Shown, Plotted):
    """Signals of one valve, each of shape (n,) or None where it was not recorded.

    Parameters
    ----------
    name : str
        What the record is called in texts and pictures.
    source : str or None
        The file that it came from.
    time, current, pressure, position, force : array, shape (n,), or None
        Time [s], current [A], gauge pressure of the actuator [Pa], position [m], force on the stem [N].
        Stored as read-only float64.
    position_unit : "m" or "%"
        "%" where the position came in percent and no rated travel was known; it is then kept as a
        fraction of the rated travel, 1 for 100 %.
    warnings : tuple of str
        What is doubtful about the record though it can be worked with.

    Raises
    ------
    InputError
        If the signals differ in length, or there is none.
    """

    name: str
    source: str | None = None
    time: Signal | None = None
    current: Signal | None = None
    pressure: Signal | None = None
    position: Signal | None = None
    force: Signal | None = None
    position_unit: str = "m"
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        lengths = {}
        for name in SIGNALS:
            values = getattr(self, name)
            if values is None:
                continue
            values = _frozen(values)
            if values.ndim != 1:
                raise InputError("a signal has one dimension", f"{name} has {values.ndim}", "pass one array each")
            lengths[name] = values.size
            object.__setattr__(self, name, values)
        if not lengths:
            raise InputError("a record has at least one signal", "got none", "pass current and position")
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{name} {size}" for name, size in lengths.items())
            raise InputError("the signals of a record are equally long", f"got {found}", "cut them to one length")
        if self.position_unit not in ("m", "%"):
            raise InputError("position is in m or %", f"got {self.position_unit!r}", "convert it first")
        object.__setattr__(self, "warnings", tuple(self.warnings))

    @classmethod
    def from_arrays(
        cls,
        name: str = "record",
        *,
        time: npt.ArrayLike | None = None,
        current: npt.ArrayLike | None = None,
        pressure: npt.ArrayLike | None = None,
        position: npt.ArrayLike | None = None,
        force: npt.ArrayLike | None = None,
        position_unit: str = "m",
        warnings: tuple[str, ...] = (),
    ) -> Record:
        """Make a record of arrays that are in SI units already; they are copied, not checked as a file is.

        Examples
        --------
        >>> record = Record.from_arrays("two steps", time=[0, 0.1], current=[0.004, 0.012])
        >>> record.kind, len(record)
        ('time', 2)
        """
        signals = {
            "time": time,
            "current": current,
            "pressure": pressure,
            "position": position,
            "force": force,
        }
        arrays = {
            key: None if values is None else np.array(values, dtype=np.float64) for key, values in signals.items()
        }
        return cls(name, None, **arrays, position_unit=position_unit, warnings=warnings)

    def columns(self) -> dict[str, Any]:
        """Return the signals as a file has them, by name with unit, as `read_record` takes them."""
        from valvemodel.records.table import usual_columns

        return usual_columns(
            **{name: values for name in SIGNALS if (values := getattr(self, name)) is not None},
            is_percent=self.position_unit == "%",
        )

    def at_rows(self, rows: slice) -> Record:
        """Return the same record with some of its rows alone."""
        return replace(self, **{name: values[rows] for name in SIGNALS if (values := getattr(self, name)) is not None})

    def to_pandas(self) -> pandas.DataFrame:
        """Return a DataFrame of the signals, by name with unit, as `read_record` takes it.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        from valvemodel.records.frame import make_frame

        return make_frame(self.columns())

    def _card(self) -> Card:
        return record_card(self)

    def __len__(self) -> int:
        """Return the number of samples, or of pairs of a loop."""
        return next(values.size for name in SIGNALS if (values := getattr(self, name)) is not None)

    @property
    def kind(self) -> str:
        """What was recorded: "stem" without current, "loop" without time, else "time"."""
        if self.current is None:
            return "stem"
        return "loop" if self.time is None else "time"

    @property
    def interval(self) -> float:
        """The median sampling interval. [s]

        Raises
        ------
        InputError
            If the record has no time, or fewer than two samples.
        """
        if self.time is None or self.time.size < 2:
            raise InputError(
                "a sampling interval takes two instants",
                f"{self.name} has no time column",
                "use a time record",
            )
        return float(np.median(np.diff(self.time)))


SIGNALS = ("time", "current", "pressure", "position", "force")
"""In the order in which they are written."""


def _frozen(values: npt.ArrayLike) -> Signal:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array
