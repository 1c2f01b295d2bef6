"""What README.md shows of a diagnosis: its answer in words and its picture, renewed by `python docs/demo.py`."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from diagnosis.report import Evidence, RecordEvidence

ROOT = Path(__file__).resolve().parents[1]
RECORD = ROOT / "diagnosis" / "examples" / "demo.csv"
PICTURE = ROOT / "docs" / "pictures" / "diagnosis.png"
OPENING, CLOSING = "<!-- demo: python docs/demo.py -->", "<!-- end of demo -->"
PLACES = {"report": "demo-report/report.html", "files": "demo-report"}
SIZE, RESOLUTION = (10.0, 4.4), 110
"""Of the picture. [in], [1/in]"""
COLOURS = 48
"""Enough for lines and letters, and a third of the bytes."""
SHOWN = 0.2, 0.5
"""Before and after the instant at which the refitted base is farthest off. [s]"""


def answered(content: dict[str, Any]) -> str:
    """Return the block as it stands in README.md."""
    from rich.console import Console

    from diagnosis.report import print_answer

    text = io.StringIO()
    print_answer(content, Console(file=text, width=80), PLACES)
    return "\n".join([OPENING, "```text", text.getvalue().rstrip(), "```", CLOSING])


def draw(content: dict[str, Any], evidence: Evidence, place: Path) -> None:
    """Draw the answer: headline, a part of the record beside the models, and how far the gap shrinks."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    from diagnosis.report.figures import draw_steps, draw_time
    from diagnosis.report.pictures import cause_label
    from diagnosis.report.svg import SETTINGS
    from diagnosis.report.words import make_answer

    answer, whole = make_answer(content), evidence.records[0]
    worst = whole.time[abs(whole.measured - whole.refitted).argmax()]
    record = part_of(whole, worst - SHOWN[0], worst + SHOWN[1])
    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=SIZE, dpi=RESOLUTION)
        FigureCanvasAgg(figure)
        figure.text(0.02, 0.92, answer.headline, fontsize=17, fontweight="bold")
        figure.text(0.02, 0.80, f"{answer.where[0]}\n{answer.closes}", fontsize=10, linespacing=1.5)
        draw_time(figure.add_axes((0.065, 0.12, 0.53, 0.56)), record, evidence.unit, cause_label(content))
        draw_steps(figure.add_axes((0.645, 0.12, 0.335, 0.62)), evidence.steps, evidence.unit)
        drawn = io.BytesIO()
        figure.savefig(drawn, format="png")
    Image.open(drawn).convert("RGB").quantize(COLOURS).save(place, optimize=True)


def part_of(record: RecordEvidence, start: float, end: float) -> RecordEvidence:
    """Return a part of a record, from start to end [s]."""
    kept = (record.time >= start) & (record.time <= end)
    arrays = {name: each[kept] for name, each in vars(record).items() if hasattr(each, "shape")}
    return replace(record, **arrays)


def main() -> None:
    """Diagnose the bundled record, and renew the block and the picture."""
    from diagnosis import diagnose
    from valvemodel import read_record

    found = diagnose(read_record(RECORD))
    content = found.as_json()
    readme = ROOT / "README.md"
    before, rest = readme.read_text(encoding="utf-8").split(OPENING)
    readme.write_text(before + answered(content) + rest.split(CLOSING)[1], encoding="utf-8")
    PICTURE.parent.mkdir(exist_ok=True)
    draw(content, found.evidence(), PICTURE)


if __name__ == "__main__":
    main()
