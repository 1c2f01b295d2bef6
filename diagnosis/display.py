"""How a diagnosis shows itself in a notebook: a card in the report's words, its pictures, its causes as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from valvemodel.display import Card, Shown, Table, warning_lines
from valvemodel.drawing import axes_or_new
from valvemodel.errors import InputError

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from diagnosis.report import Evidence, RecordEvidence
    from diagnosis.report.words import Answer

SHOWN_CAUSES = 5
"""Causes that a card lists; `to_pandas` has all."""

WITH_CAUSE = "with the cause"


class Told(Shown):
    """What can tell a diagnosis: the content of diagnosis.json and the evidence behind it."""

    def as_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        raise NotImplementedError

    def evidence(self) -> Evidence:
        """Return what the pictures show."""
        raise NotImplementedError

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

    def _record(self, number: int) -> RecordEvidence:
        records = self.evidence().records
        if not 0 <= number < len(records):
            raise InputError(f"a record is numbered from 0 to {len(records) - 1}", f"got {number}", "choose one")
        return records[number]

    def _card(self) -> Card:
        from diagnosis.report.words import make_answer

        return diagnosis_card(make_answer(self.as_json()))


def diagnosis_card(answer: Answer) -> Card:
    """Show a diagnosis: its answer, where, how far the gap shrinks, the causes, what cannot be told, what is next."""
    causes = tuple(
        (
            each.title,
            each.probability_text,
            each.closed,
            "; ".join(f"{one.name} = {one.value}" for effect in each.effects for one in effect.parameters)
            if number == 0
            else "",
        )
        for number, each in enumerate(answer.causes[:SHOWN_CAUSES])
    )
    parts: tuple[str | Table, ...] = (
        " ".join(part for part in (answer.explanation, answer.confidence) if part),
        " ".join(answer.where),
        Table(f"Gap. {answer.gap_measure}", ("model", "gap"), answer.gap_rows),
        Table("Causes", ("cause", "probability", "closes", "parameters"), causes),
        " ".join(part for part in (answer.alternatives_sentence, answer.hiding) if part),
        answer.next_step,
        *warning_lines(answer.warnings),
    )
    return Card(answer.headline, tuple(part for part in parts if part))
