"""How is a diagnosis told? One answer in words, on a page with pictures and on the terminal."""

from diagnosis.report.answer import print_answer
from diagnosis.report.evidence import Evidence, Rank, RecordEvidence, Step
from diagnosis.report.page import render_page, write_page

__all__ = ["Evidence", "Rank", "RecordEvidence", "Step", "print_answer", "render_page", "write_page"]
