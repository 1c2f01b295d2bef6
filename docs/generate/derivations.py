"""The paper's equations derived again: one page, from the findings that `valvemodel derive` prints."""

from __future__ import annotations

import mkdocs_gen_files

from derivations import Verdict, verdicts


def escaped(text: str) -> str:
    """Text that Markdown leaves as it stands."""
    for letter in "\\`*_{}[]<>|$":
        text = text.replace(letter, f"\\{letter}" if letter not in "<>" else {"<": "&lt;", ">": "&gt;"}[letter])
    return text


def section(verdict: Verdict) -> str:
    name = f"Equation ({verdict.equation})" if verdict.equation[0].isdigit() else verdict.equation
    lines = [f"## {name}: {verdict.verdict}"]
    for title, formula, text in (
        ("Printed", verdict.printed_latex, verdict.printed),
        ("Derived", verdict.derived_latex, verdict.derived),
    ):
        lines.append(f"{title}: $${formula}$$" if formula else f"{title}: {escaped(text)}")
    lines.append("\n".join(f"1. {escaped(step)}" for step in verdict.steps))
    lines.append(f"**{escaped(verdict.right)}**")
    return "\n\n".join(lines)


with mkdocs_gen_files.open("explanation/derivations.md", "w") as page:
    found = verdicts()
    page.write("# The paper's equations, derived again\n\n")
    page.write(
        f"{len(found)} findings, each computed by comparing what is derived with what is printed "
        "(`valvemodel derive`). The numbers of the equations are the paper's.\n\n"
    )
    page.write("\n\n".join(map(section, found)) + "\n")
