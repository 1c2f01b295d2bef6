"""What a blind test says in words, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from diagnosis.report.amounts import percent

KIND_TITLES = {
    "single": "one effect",
    "pair": "two effects",
    "none": "no effect",
    "left-out": "effect taken out of the candidates",
}

_RIGHT = {
    "single": "named right, or in a declared set of at most three",
    "pair": "both named right, or in a declared set of at most three",
    "none": "says none",
    "left-out": "says unknown or names a stated alias",
}


def rate_words(rate: Mapping[str, Any]) -> str:
    """Write a rate as "94.0 % (47 of 50; 84 to 98 %)", the interval last."""
    if not rate["of"]:
        return "–"
    low, high = rate["interval"]
    return f"{100 * rate['share']:.1f} % ({rate['hits']} of {rate['of']}; {100 * low:.0f} to {100 * high:.0f} %)"


def rate_rows(content: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    """Yield question, what was counted, the diagnosis's rate and the baseline's, empty where it was not run."""
    baseline = content["baseline"] or {}
    for kind, counts in content["kinds"].items():
        title = KIND_TITLES[kind]
        beside = baseline.get(kind)
        yield title, _RIGHT[kind], rate_words(counts["right"]), rate_words(beside["right"]) if beside else ""
        if counts["right_where_visible"]["of"] < counts["plants"]:
            yield title, "… where a refitted base does not imitate it", rate_words(counts["right_where_visible"]), ""
        if kind in ("single", "pair"):
            yield title, "right as first choice", rate_words(counts["first_choice"]), ""
        if kind == "none":
            yield title, "false alarm or unknown", rate_words(counts["false_alarm"]), ""
        else:
            counted = "stage right, or in a declared set of at most two"
            yield title, counted, rate_words(counts["stage"]), rate_words(beside["stage"]) if beside else ""


def figure_rows(content: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the figures that are no rates: calibration, closure, seconds."""
    calibration, closure = content["calibration"]["expected_calibration_error"], content["closure"]
    if calibration is not None:
        yield "probability said against frequency found", f"off by {100 * calibration:.1f} points (expected error)"
    if closure["median"] is not None:
        free = closure["lowest_decile_free"]
        beside = f", {percent(free)} if all models run free" if free is not None else ""
        yield (
            "gap closed on an unseen record of the same valve",
            f"median {percent(closure['median'])}, lowest decile {percent(closure['lowest_decile'])}{beside} "
            f"({closure['plants']} plants)",
        )
    black_box = content["black_box"]
    if black_box["median"] is not None:
        yield (
            "gap closed on held-out blocks by a black box without physics",
            f"median {percent(max(black_box['median'], 0.0))}; by the cause {percent(black_box['cause_median'])} "
            f"({black_box['plants']} plants)",
        )
    if content["sham_wins"]["of"]:
        yield "sham effects, which cannot be in a valve, would have won", rate_words(content["sham_wins"])
    for title, spent in (("seconds a record, one core", "seconds"), ("of these, computing", "computing_seconds")):
        seconds = content[spent]
        if seconds["median"] is not None:
            yield title, f"median {seconds['median']:.1f} s, 95 % within {seconds['percentile_95']:.1f} s"


def lines_of(content: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of the terminal."""
    yield f"{content['plants']} plants, sealed under {content['sealed_sha256'][:16]}…"
    before = ""
    for title, counted, found, beside in rate_rows(content):
        if title != before:
            yield f"{title[:1].upper()}{title[1:]}"
            before = title
        yield f"  {found:42} {counted}" + (f"; baseline {beside}" if beside else "")
    for title, words in figure_rows(content):
        yield f"{title[:1].upper()}{title[1:]}: {words}"
