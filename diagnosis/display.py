"""How a diagnosis shows itself in a notebook: a card in the report's words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvemodel.display import Card, Table, warning_lines

if TYPE_CHECKING:
    from diagnosis.report.words import Answer

SHOWN_CAUSES = 5
"""Causes that a card lists; `to_pandas` has all."""


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
