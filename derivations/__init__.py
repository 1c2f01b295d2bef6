"""What is true on paper: the paper's equations derived again, each compared with its printed form."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from derivations.verdict import VERDICT_KINDS, Verdict

verdict_kinds = VERDICT_KINDS

__all__ = ["Verdict", "latex", "render", "verdict_kinds", "verdicts"]


def verdicts() -> list[Verdict]:
    """Derive every equation again and return what was found, in the order of the paper."""
    return list(_verdicts())


@cache
def _verdicts() -> tuple[Verdict, ...]:
    # Some seconds of algebra; the paper does not change while a program runs.
    from derivations.checks import all_verdicts
    from derivations.paper import PAPER

    return tuple(all_verdicts(PAPER))


def render() -> dict[str, str]:
    """Return the text of each generated module by its path from the repository's root."""
    from derivations.codegen import render as generate

    return generate()


def latex(findings: Iterable[Verdict] | None = None) -> str:
    """Return a LaTeX document part that shows the findings, all by default, for an article with amsmath."""
    from derivations.typesetting import document

    return document(verdicts() if findings is None else findings)
