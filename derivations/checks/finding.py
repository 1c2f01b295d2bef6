"""Makes a verdict out of a comparison or of a fact that was computed."""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from derivations.compare import Comparison, classify
from derivations.dimensions import fault
from derivations.glossary import label, typeset
from derivations.paper import Paper
from derivations.verdict import Verdict

AS_PRINTED = "As printed."


def compared(
    paper: Paper,
    equation: str,
    derived: sp.Expr,
    steps: Iterable[str],
    right: str = "",
    *,
    inherited: sp.Expr | None = None,
    key: str = "",
) -> Verdict:
    """Compare a printed right side with the derived one; `key` picks one of several printed forms."""
    printed = paper[key or equation]
    comparison = classify(printed.right, derived, left=printed.left, inherited=inherited)
    shown = f"{label(printed.left)} = {label(derived)}"
    return Verdict(
        equation,
        comparison.verdict,
        printed.text,
        shown,
        (*steps, f"derived: {shown}", f"printed: {printed.text}", _outcome(comparison)),
        AS_PRINTED if comparison.verdict == "holds" else right or f"{shown}.",
        printed.latex,
        f"{typeset(printed.left)} = {typeset(derived)}",
    )


def stated(paper: Paper, equation: str, why: str, *, is_met: bool = True, otherwise: str = "sign error") -> Verdict:
    """Judge an equation that the paper states, not derives, by its dimensions and one fact."""
    printed = paper[equation]
    wrong = fault(printed.left, printed.right)
    verdict = "misprint" if wrong else "holds" if is_met else otherwise
    steps = (
        f"premise: {why}",
        wrong or "both sides have the same dimension",
        f"it meets that premise: {is_met}",
    )
    right = AS_PRINTED if verdict == "holds" else f"What must hold: {why}."
    return Verdict(equation, verdict, printed.text, printed.text, steps, right, printed.latex, printed.latex)


def found(
    equation: str,
    verdict: str,
    printed: str | sp.Basic,
    derived: str | sp.Basic,
    steps: Iterable[str],
    right: str,
) -> Verdict:
    """Report a fact; `verdict` has been computed by the caller."""
    return Verdict(
        equation,
        verdict,
        printed if isinstance(printed, str) else label(printed),
        derived if isinstance(derived, str) else label(derived),
        tuple(steps),
        AS_PRINTED if verdict == "holds" else right or f"What follows is {derived}.",
        "" if isinstance(printed, str) else typeset(printed),
        "" if isinstance(derived, str) else typeset(derived),
    )


def _outcome(comparison: Comparison) -> str:
    return f"{comparison.sentence}: {comparison.verdict}"
