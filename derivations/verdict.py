"""What is said of one equation, table or sentence of the paper."""

from __future__ import annotations

from dataclasses import dataclass

VERDICT_KINDS = (
    "holds",
    "misprint",
    "sign error",
    "inherits an error",
    "wrong premise",
    "not determined",
    "not reproducible",
    "incomplete",
)


@dataclass(frozen=True)
class Verdict:
    """One finding: what is printed, what follows when it is derived again, and the steps between.

    `equation` is an equation number of the paper, or an id such as `table-2`, `state-4`, `text-n`.
    `right` says in one sentence what is right. `printed_latex` and `derived_latex` typeset both forms.
    """

    equation: str
    verdict: str
    printed: str
    derived: str
    steps: tuple[str, ...]
    right: str
    printed_latex: str = ""
    derived_latex: str = ""

    def __post_init__(self) -> None:
        assert self.verdict in VERDICT_KINDS, f"{self.equation}: {self.verdict!r}"
        assert all((self.steps, self.right, self.printed, self.derived)), self.equation
