"""What shows itself in a notebook is a small card, well formed, readable aloud, and needs nothing from elsewhere."""

import re
from html.parser import HTMLParser

import pytest

from valvemodel import read_valve

SHOWN = ("record", "run", "model", "outcome", "diagnosis")
LARGEST = 12_000
"""What a card may weigh. [byte]"""


class Reader(HTMLParser):
    """Keeps what a screen reader would say, and the tags that are open."""

    def __init__(self) -> None:
        super().__init__()
        self.open, self.seen, self.texts = [], [], []

    def handle_starttag(self, tag, attributes):
        self.open.append(tag)
        self.seen.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def read(markup: str) -> Reader:
    reader = Reader()
    reader.feed(markup)
    reader.close()
    assert not reader.open
    return reader


@pytest.mark.parametrize("name", SHOWN)
def test_card_is_small_well_formed_and_says_its_headings(name: str, request):
    thing = request.getfixturevalue(name)
    markup = thing._repr_html_()
    assert len(markup.encode()) < LARGEST
    assert not re.search(r"https?:|src=|href=|<script|<style|url\(", markup)
    reader = read(markup)
    tables = [tag for tag, _ in reader.seen if tag == "table"]
    assert tables
    assert len([tag for tag, _ in reader.seen if tag == "caption"]) == len(tables)
    assert all(given.get("scope") in ("col", "row") for tag, given in reader.seen if tag == "th")
    assert repr(thing) in reader.texts, "elsewhere the title stands alone"
    assert "\n" not in repr(thing)
    assert len(repr(thing)) < 200


def test_valve_says_where_its_numbers_are_from():
    valve = read_valve("calibrated")
    markup = valve._repr_html_()
    assert all(name in markup for name in valve.entries)
    assert "Table 2, S_1" in read(markup).texts


def test_names_of_files_are_no_markup(record):
    assert "a &lt; b" in record._repr_html_()


def test_record_card_has_the_ends_of_each_signal_and_the_warnings(record):
    from dataclasses import replace

    markup = replace(record, warnings=("position is coarse",))._repr_html_()
    assert f"{1e3 * record.current.max():.4g} mA" in markup
    assert "Warning: position is coarse" in markup


def test_fit_card_and_terminal_say_the_same(outcome, capsys):
    from valvemodel.commands.fitted import print_outcome

    print_outcome(outcome)
    printed = capsys.readouterr().out
    cells = [text for text in read(outcome._repr_html_()).texts if re.fullmatch(r"[\d.]+ \S+ .*|[\d.]+ \S+", text)]
    assert len(cells) >= 2 * len(outcome.parameters)
    assert all(cell in printed for cell in cells)


def test_diagnosis_card_and_report_say_the_same(diagnosis):
    from diagnosis.report.words import make_answer

    answer = make_answer(diagnosis.as_json())
    texts = read(diagnosis._repr_html_()).texts
    assert answer.headline == repr(diagnosis)
    for text in (answer.next_step, answer.alternatives_sentence, *(value for _, value in answer.gap_rows)):
        assert text in texts
