"""The page says the answer, holds everything itself, and takes nothing from a record as markup."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from report_samples import SAMPLES, cause, effect, record

from diagnosis.report import Evidence, Rank, Step, render_page, write_page

VOID = {"meta", "link", "br", "hr", "img", "input"}
HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)> &amp; $\\frac{x$ {{ 7*7 }}"


class Reader(HTMLParser):
    """Collects elements, attributes and text, and whether each end fits its start."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> at {self.getpos()}"
        assert self.open.pop() == tag, f"</{tag}> at {self.getpos()}"

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text.append(data)


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return reader


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    return {name: render_page(*make()) for name, make in SAMPLES.items()}


@pytest.mark.parametrize("name", SAMPLES)
def test_markup_is_balanced_and_ids_are_unique(pages: dict[str, str], name: str) -> None:
    reader = read(pages[name])
    ids = [value for _, attribute, value in reader.attributes if attribute == "id"]
    assert len(ids) == len(set(ids))
    references = {value[1:] for _, attribute, value in reader.attributes if attribute == "href" and value[:1] == "#"}
    references |= {found for _, _, value in reader.attributes for found in re.findall(r"url\(#([^)]*)\)", value)}
    assert references <= set(ids)


@pytest.mark.parametrize("name", SAMPLES)
def test_page_loads_nothing_and_runs_nothing(pages: dict[str, str], name: str) -> None:
    reader = read(pages[name])
    assert not {"script", "iframe", "object", "embed", "img", "base", "form", "image"} & set(reader.tags)
    assert not [found for found in reader.attributes if found[1].startswith("on")]
    loads = [found for found in reader.attributes if found[1] in ("src", "href", "srcset", "xlink:href", "action")]
    assert all(value.startswith("#") or value == "data:," for _, _, value in loads)
    assert not re.search(r"@import|url\((?!#)", pages[name])
    addresses = {value for _, attribute, value in reader.attributes if "://" in value and attribute[:5] != "xmlns"}
    assert addresses == set()
    assert len(pages[name]) < 1_000_000


@pytest.mark.parametrize("name", SAMPLES)
def test_page_shows_no_missing_number(pages: dict[str, str], name: str) -> None:
    reader = read(pages[name])
    shown = " ".join(reader.text + [value for _, attribute, value in reader.attributes if attribute != "d"])
    assert not re.search(r"\b(nan|inf|None|NaN|null|undefined)\b", shown)
    assert "{{" not in shown
    assert not re.search(r"\bnan\b", pages[name])


@pytest.mark.parametrize("name", SAMPLES)
def test_every_picture_has_words(pages: dict[str, str], name: str) -> None:
    reader = read(pages[name])
    pictures = [value for tag, attribute, value in reader.attributes if (attribute, value) == ("role", "img")]
    labels = [value for _, attribute, value in reader.attributes if attribute == "aria-label"]
    assert len(pictures) >= 5
    assert len(labels) >= len(pictures)
    assert all(len(label) > 5 for label in labels)
    assert reader.tags.count("svg") == len(pictures)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "effect",
            [
                "lacks static friction or Stribeck friction",
                "very likely",
                "0.158 mm",
                "ramps at several slow speeds",
                "1.4012",
            ],
        ),
        (
            "two effects",
            ["static friction and either sensor lag, coil lag or transport delay", "stroke-d.csv"],
        ),
        ("none", ["The model lacks nothing", "cannot exclude linkage backlash", "base.json"]),
        ("unknown", ["none of the known effects explains", "not good enough", "44 %", "not determined"]),
        ("stem record", ["asymmetric viscous friction", "2.02 N", "Force against position"]),
    ],
)
def test_page_says_the_answer(pages: dict[str, str], name: str, words: list[str]) -> None:
    text = re.sub(r"\s+", " ", "".join(read(pages[name]).text))
    for each in words:
        assert each in text


def test_page_says_the_same_twice() -> None:
    assert render_page(*effect()) == render_page(*effect()) == render_page(*effect(), jobs=2)


def test_nothing_from_the_record_becomes_markup() -> None:
    diagnosis, _ = effect()
    diagnosis["warnings"] = [HOSTILE]
    diagnosis["where"]["regimes"] = [{"name": HOSTILE, "where": HOSTILE, "rms": 1e-3, "share": 0.9}]
    diagnosis["gap"]["scored_on"] = HOSTILE
    diagnosis["causes"].insert(
        0,
        cause(
            [HOSTILE],
            0.9,
            1e-4,
            0.9,
            parameters={HOSTILE: {HOSTILE: {"value": 1.0, "unit": HOSTILE, "std": 1}}},
        ),
    )
    hostile = Evidence(
        records=(replace(record(HOSTILE, with_pressure=True)),),
        steps=(Step(HOSTILE, 1e-3), Step("noise floor", 1e-4)),
        ranking=(Rank(HOSTILE, (HOSTILE,), 1e-3, 0.9e-3, 1.1e-3, 0.5),),
        noise_floor=1e-4,
        unit="m",
        seconds=1.0,
        valve_name=HOSTILE,
        warnings=(HOSTILE + " second",),
    )
    page = render_page(diagnosis, hostile)
    reader = read(page)
    assert "script" not in reader.tags
    assert "img" not in reader.tags
    assert not [found for found in reader.attributes if found[1].startswith("on")]
    assert "<script" not in page
    assert HOSTILE in "".join(reader.text)
    assert any(HOSTILE in value for _, name, value in reader.attributes if name == "aria-label")


def test_names_that_no_file_can_hold_are_shown_all_the_same(tmp_path: Path) -> None:
    diagnosis, evidence = effect()
    odd = replace(
        evidence,
        records=(record("valve\udcff\x1b[31m 弁.csv", count=300),),
        steps=(Step("弁 as given", 1e-3), Step("noise floor", 1e-4)),
    )
    write_page(tmp_path / "report.html", diagnosis, odd)
    assert "弁.csv" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_little_data_makes_a_page() -> None:
    diagnosis, evidence = effect()
    flat = record("flat.csv", count=2)
    flat = replace(
        flat,
        measured=np.full(2, np.nan),
        refitted=np.zeros(2),
        with_cause=None,
        as_given=None,
        current=None,
        held_out=np.zeros(2, dtype=bool),
        mode=np.zeros(2, dtype=int),
    )
    bare = replace(evidence, records=(flat,), steps=(), ranking=(), seconds=None, noise_floor=None)
    diagnosis |= {"causes": [], "where": {"stage": None}, "gap": {"unit": "m"}}
    read(render_page(diagnosis, bare))


def test_evidence_of_unequal_lengths_is_refused() -> None:
    with pytest.raises(AssertionError, match=r"stroke\.csv: measured has shape"):
        replace(record(), measured=np.zeros(3))
