"""Typesets the findings as a LaTeX document part, for an article with amsmath."""

from __future__ import annotations

from collections.abc import Iterable

from derivations.verdict import Verdict

_ESCAPES = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "_": r"\_",
    "^": r"\^{}",
    "%": r"\%",
    "&": r"\&",
    "#": r"\#",
    "$": r"\$",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


def escaped(text: str) -> str:
    """Return text that LaTeX prints as it stands."""
    return "".join(_ESCAPES.get(letter, letter) for letter in text.replace("**", "^"))


def document(findings: Iterable[Verdict]) -> str:
    """Return one section, with a subsection for each finding."""
    parts = "\n".join(map(_finding, findings))
    return "\\section{The paper's equations, derived again}\n\\allowdisplaybreaks\n\n" + parts


def _finding(verdict: Verdict) -> str:
    number = verdict.equation
    title = f"Equation ({number})" if number[0].isdigit() else number
    steps = "\n".join(f"  \\item {escaped(step)}" for step in verdict.steps)
    return f"""\\subsection*{{{escaped(title)}: {verdict.verdict}}}
{_forms(verdict)}
\\begin{{itemize}}
{steps}
\\end{{itemize}}
{escaped(verdict.right)}
"""


def _forms(verdict: Verdict) -> str:
    """Both forms typeset where they are expressions, else as text."""
    lines = [
        f"\\text{{{name}:}}\\quad & {formula}"
        for name, formula in (("printed", verdict.printed_latex), ("derived", verdict.derived_latex))
        if formula
    ]
    aligned = "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}" if lines else ""
    told = [
        f"\\noindent {name}: {escaped(text)}."
        for name, text, formula in (
            ("Printed", verdict.printed, verdict.printed_latex),
            ("Derived", verdict.derived, verdict.derived_latex),
        )
        if not formula
    ]
    return "\n\n".join([*told, aligned] if aligned else told)
