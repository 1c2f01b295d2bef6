"""One file a part of the paper; each yields its findings, in the paper's order."""

from __future__ import annotations

from derivations.checks import (
    ansatz,
    electromagnet,
    integration,
    nozzle,
    self_calibration,
    stem,
    tables,
    texts,
)
from derivations.paper import Paper
from derivations.verdict import Verdict

_PARTS = (stem, nozzle, electromagnet, ansatz, integration, self_calibration, tables, texts)


def all_verdicts(paper: Paper) -> list[Verdict]:
    """Derive everything again and compare it with a paper."""
    return [verdict for part in _PARTS for verdict in part.verdicts(paper)]
