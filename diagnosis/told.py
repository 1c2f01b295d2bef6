"""What every diagnosis tells, of a whole valve or of its stem alone, and how it is written down and drawn."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from diagnosis.causes import Cause
from diagnosis.score import Errors
from diagnosis.whereabouts.regimes import Regime
from valvemodel.display import Card, Shown
from valvemodel.drawing import axes_or_new
from valvemodel.errors import InputError
from valvemodel.files import make_folder, write_json
from valvemodel.model import Model

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from diagnosis.report import Evidence, RecordEvidence

SCHEMA = "valvemodel.diagnosis/1"

WITH_CAUSE = "with the cause"


@dataclass(frozen=True, eq=False, repr=False)
class Told(Shown):
    """A diagnosis, in SI units, with all that one of a whole valve and one of its stem alone have in common.

    Attributes
    ----------
    verdict : str
        `effect`, `none` or `unknown`.
    stage : str or None
        Where the gap most probably lies, if there is one.
    stage_probability : dict of float
    regimes : list of Regime
        Where the error of the refitted base is large, the largest first.
    causes : list of Cause
        All that were tried, in the order of telling.
    unknown_probability : float
    refitted : Errors
        Of the refitted base, in the unit of the gap.
    floor : float
        What noise leaves of the gap, or the best fit does, in its unit.
    given : Model
        The valve as given.
    steps : list of (str, float)
        The gap step by step, in its unit.
    warnings : tuple of str
    seconds : float
        That the diagnosis took.
    """

    verdict: str
    stage: str | None
    stage_probability: dict[str, float]
    regimes: list[Regime]
    causes: list[Cause]
    unknown_probability: float
    refitted: Errors
    floor: float
    given: Model
    steps: list[tuple[str, float]]
    warnings: tuple[str, ...]
    seconds: float

    @property
    def cause(self) -> Cause:
        """The cause that is shown: the most probable one, of which the verdict speaks unless it is unknown.

        Where it is, causes that are a series of waves come last.
        """
        return self.causes[0]

    @property
    @abstractmethod
    def models(self) -> dict[str, Model]:
        """The models that are written down, by the name of the file: the refitted base, and what was found."""

    @abstractmethod
    def as_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""

    @abstractmethod
    def evidence(self) -> Evidence:
        """Return what the pictures show."""

    def write(self, folder: Path, *, jobs: int | None = 1) -> dict[str, Path]:
        """Write diagnosis.json, base.json, model.json and report.html, and return their places.

        So many processes draw at the same time; None is one a core.
        """
        from diagnosis.report import write_page

        folder, content, models = make_folder(folder), self.as_json(), self.models
        places = {name: folder / name for name in ("diagnosis.json", *models, "report.html")}
        write_json(places["diagnosis.json"], content)
        for name, model in models.items():
            model.write(places[name])
        write_page(places["report.html"], content, self.evidence(), jobs=jobs)
        return places

    def to_pandas(self) -> pandas.DataFrame:
        """Return a DataFrame of all causes, the most probable first; errors in SI units, no effects is `none`.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        from valvemodel.records.frame import make_frame

        content = self.as_json()
        causes, unit = content["causes"], content["gap"]["unit"]
        ends = [each["gap_closed_interval"] or (None, None) for each in causes]
        columns = {
            "probability": [each["probability"] for each in causes],
            f"gap_after [{unit}]": [each["gap_after"] for each in causes],
            "gap_closed": [each["gap_closed"] for each in causes],
            "gap_closed_low": [low for low, _ in ends],
            "gap_closed_high": [high for _, high in ends],
        }
        return make_frame(columns, index=[" + ".join(each["effects"]) or "none" for each in causes])

    def plot(self, axes: Axes | None = None, *, record: int = 0) -> Axes:
        """Plot measured and modelled signal of a record over time on axes, by default new ones, and return them."""
        from diagnosis.report.figures import draw_time

        axes = axes_or_new(axes, size=(7.0, 3.2))
        draw_time(axes, self._record(record), self.evidence().unit, WITH_CAUSE)
        return axes

    def plot_loop(self, axes: Axes | None = None, *, record: int = 0) -> Axes:
        """Plot measured and modelled signal of a record over what drives it; arguments as of `plot`."""
        from diagnosis.report.figures import draw_loop

        axes = axes_or_new(axes, size=(5.0, 3.6))
        draw_loop(axes, self._record(record), self.evidence().unit, WITH_CAUSE)
        return axes

    def plot_steps(self, axes: Axes | None = None) -> Axes:
        """Plot the gap shrinking step by step; arguments as of `plot`."""
        from diagnosis.report.figures import draw_steps

        evidence = self.evidence()
        axes = axes_or_new(axes, size=(5.0, 0.6 * max(3, len(evidence.steps)) + 0.6))
        draw_steps(axes, evidence.steps, evidence.unit)
        return axes

    def plot_causes(self, axes: Axes | None = None) -> Axes:
        """Plot the gap that each cause leaves, with its interval and probability; arguments as of `plot`."""
        from diagnosis.report.figures import draw_ranking

        evidence = self.evidence()
        axes = axes_or_new(axes, size=(7.0, 3.8))
        draw_ranking(axes, evidence.ranking, evidence.noise_floor, evidence.unit)
        return axes

    def _content(self) -> dict[str, Any]:
        """Return the part of diagnosis.json that says which, where and how sure."""
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "where": {
                "stage": self.stage,
                "stage_probability": self.stage_probability,
                "regimes": [asdict(regime) for regime in self.regimes],
            },
            "causes": [cause.as_json() for cause in self.causes],
            "unknown_probability": self.unknown_probability,
        }

    def _record(self, number: int) -> RecordEvidence:
        records = self.evidence().records
        if not 0 <= number < len(records):
            raise InputError(f"a record is numbered from 0 to {len(records) - 1}", f"got {number}", "choose one")
        return records[number]

    def _card(self) -> Card:
        from diagnosis.display import diagnosis_card
        from diagnosis.report.words import make_answer

        return diagnosis_card(make_answer(self.as_json()))
