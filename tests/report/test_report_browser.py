"""The page in a browser: opened from disk it asks for nothing, fits a phone, can be read, and prints."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest
from browser import complaints, measured, needs_chromium, requests_of_page, visit
from report_samples import SAMPLES

from diagnosis.report import render_page, write_page

PHONE, DESK = 390, 1200
READABLE = 4.5
"""Contrast of text, WCAG 2.2 level AA."""

pytestmark = needs_chromium


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict]:
    pages = {name: render_page(*make()) for name, make in SAMPLES.items()}
    return measured(pages, (PHONE, DESK), tmp_path_factory.mktemp("frames"))


@pytest.mark.parametrize("name", SAMPLES)
def test_page_asks_for_nothing_and_complains_of_nothing(name: str, tmp_path: Path) -> None:
    write_page(tmp_path / "report.html", *SAMPLES[name]())
    done = visit(tmp_path / "report.html", "--dump-dom", f"--log-net-log={tmp_path / 'net.json'}")
    assert "What to do next" in done.stdout
    assert complaints(done) == []
    assert requests_of_page(tmp_path / "net.json") == []


def test_a_page_that_asks_or_complains_would_be_caught(tmp_path: Path) -> None:
    (tmp_path / "bad.html").write_text('<img src="http://127.0.0.1:9/a.png"><script>console.error("no")</script>')
    done = visit(tmp_path / "bad.html", "--dump-dom", f"--log-net-log={tmp_path / 'net.json'}")
    assert "http://127.0.0.1:9/a.png" in requests_of_page(tmp_path / "net.json")
    assert complaints(done)


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("width", [PHONE, DESK])
def test_page_is_as_wide_as_the_screen(found: dict[str, dict], name: str, width: int) -> None:
    layout = found[f"{name} {width}"]
    assert layout["width"] <= width
    assert layout["beyond"] == []
    assert layout["scrolled"] == 0


@pytest.mark.parametrize("name", SAMPLES)
def test_the_answer_is_the_first_screen(found: dict[str, dict], name: str) -> None:
    assert found[f"{name} {DESK}"]["answer"] < 900


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("width", [PHONE, DESK])
def test_every_text_stands_out(found: dict[str, dict], name: str, width: int) -> None:
    contrast, text = found[f"{name} {width}"]["contrast"]
    assert contrast >= READABLE, text


@pytest.mark.parametrize("name", SAMPLES)
def test_headings_leave_no_level_out(found: dict[str, dict], name: str) -> None:
    levels = found[f"{name} {DESK}"]["headings"]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))


@pytest.mark.parametrize("name", SAMPLES)
def test_a_phone_shows_as_many_pictures_as_a_desk(found: dict[str, dict], name: str) -> None:
    assert found[f"{name} {PHONE}"]["shown"] == found[f"{name} {DESK}"]["shown"] >= 4


def test_page_prints(tmp_path: Path) -> None:
    write_page(tmp_path / "report.html", *SAMPLES["effect"]())
    visit(tmp_path / "report.html", "--no-pdf-header-footer", f"--print-to-pdf={tmp_path / 'report.pdf'}")
    printed = (tmp_path / "report.pdf").read_bytes()
    assert printed.startswith(b"%PDF")
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", printed)) <= 10
