"""What a fit comes to: parameters with uncertainty, errors on fitted and unseen data, what stays open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from identification.determined.account import Account
from identification.determined.uncertainty import Estimate
from identification.results.display import fit_card, parameter_columns
from identification.results.loop_shape import FittedShape
from identification.results.residual import Residual, draw_residuals
from identification.results.residual_check import Check
from valvemodel.display import Card, Shown
from valvemodel.drawing import axes_or_new
from valvemodel.files import write_json
from valvemodel.model import Model
from valvemodel.plots import COURSE
from valvemodel.records import Record

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from identification.smooth_fit import Smoothing

SCHEMA = "valvemodel.fit/1"


@dataclass(frozen=True, repr=False)
class Outcome(Shown):
    """All that `fit.json` and `model.json` hold, in SI units.

    Attributes
    ----------
    records : tuple of str
        Their names; of those that were named alike the second is `name (2)`.
    parameters : tuple of Estimate
        Those that were fitted.
    model : Model or None
        With them; None where they make no valve that physics allows.
    rms_fitted, rms_unseen : float, float or None
        Of the final fit on all data, and of a fit to a part of them on the rest; None where nothing could be
        kept back. [unit]
    unseen : str or None
        What was kept back.
    noise : float or None
        Of the readings, estimated from themselves. [unit]
    starts : dict of float
        Fitted reading at the start of each record. [m]
    open : dict of str
        By parameter why the records do not determine it.
    loop : FittedShape or None
        Width, slope and height, where the records are settled loops.
    determined : Account
        What the records determine, before and after the fit.
    checks : tuple of Check
        Of the residuals; none for a force balance.
    route : str
        How it was searched: "exact" or "smooth".
    smoothing : tuple of Smoothing
        What smoothing did to the fit, by width; empty on the exact route.
    residuals : tuple of Residual
        What the fit leaves of each record.
    """

    records: tuple[str, ...]
    effects: tuple[str, ...]
    parameters: tuple[Estimate, ...]
    model: Model | None
    unit: str
    rms_fitted: float
    rms_unseen: float | None
    unseen: str | None
    noise: float | None
    starts: dict[str, float]
    open: dict[str, str]
    warnings: tuple[str, ...]
    seconds: float
    determined: Account
    checks: tuple[Check, ...] = ()
    route: str = "exact"
    smoothing: tuple[Smoothing, ...] = ()
    loop: FittedShape | None = None
    residuals: tuple[Residual, ...] = ()

    def to_pandas(self) -> pandas.DataFrame:
        """Return a DataFrame of the parameters in SI units: value, std, ends of the 95 % interval, whether determined.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        from valvemodel.records.frame import make_frame

        return make_frame(parameter_columns(self), index=[each.name for each in self.parameters])

    def plot_residuals(self, axes: Axes | None = None) -> Axes:
        """Plot measured less modelled over time on axes, by default of a new figure, and return them."""
        axes = axes_or_new(axes, size=COURSE)
        draw_residuals(axes, self.residuals)
        return axes

    def _card(self) -> Card:
        return fit_card(self)

    def as_json(self) -> dict[str, Any]:
        """Return the content of fit.json."""
        return {
            "schema": SCHEMA,
            "parameters": {
                each.name: {
                    "value": each.value,
                    "unit": each.unit,
                    "std": each.std,
                    "at_bound": each.is_at_bound,
                }
                for each in self.parameters
            },
            "rms": {"fitted": self.rms_fitted, "unseen": self.rms_unseen, "unit": self.unit},
            "unseen": self.unseen,
            "noise": {"value": self.noise, "unit": self.unit},
            "effects": list(self.effects),
            "not_determined": self.open,
            "determined": self.determined.as_json(),
            "residual_check": [each.as_json() for each in self.checks],
            "start_positions": {name: {"value": start, "unit": "m"} for name, start in self.starts.items()},
            **({} if self.loop is None else {"loop": self.loop.as_json()}),
            "records": list(self.records),
            "warnings": list(self.warnings),
            "seconds": self.seconds,
            "route": self.route,
            "smoothing": [each.as_json() for each in self.smoothing],
        }

    def write(self, folder: Path) -> dict[str, Path]:
        """Write fit.json and, where there is a model, model.json; return their places by name."""
        places = {"fit.json": folder / "fit.json"}
        if self.model is not None:
            places["model.json"] = folder / "model.json"
            self.model.write(places["model.json"])
        write_json(places["fit.json"], self.as_json())
        return places


def fitted_name(model: Model, records: Sequence[Record]) -> str:
    """Return the name of a model that was fitted to records."""
    return f"{model.name} fitted to {', '.join(record.name for record in records)}"
