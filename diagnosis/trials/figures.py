"""The pictures of a blind test: outcomes, calibration, closure, seconds, confusion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.report.figures import BASE, CAUSE, MEASURED, NOISE
from diagnosis.report.naming import effect_title
from diagnosis.report.svg import INK, picture, readable_on
from diagnosis.trials.marking import OUTCOMES
from valvemodel.effects import are_aliases

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = {
    "right": NOISE,
    "alias": "#7fceb9",
    "unknown": "#E69F00",
    "none": "#cfcfcf",
    "partly": "#56B4E9",
    "unsure": "#f2c9a8",
    "wrong": BASE,
    "false alarm": "#b03030",
    "failed": INK,
}
_HATCHES = {"alias": "///", "unknown": "..", "partly": "\\\\\\", "unsure": "xx", "false alarm": "++"}
"""So that neighbours are told apart without colour."""
_SQUARE = (5.0, 4.2)
_HALF_BOX = (0.14, 0.14, 0.82, 0.80)


def outcomes_picture(name: str, kinds: Mapping[str, Any]) -> str:
    """Return bars of the outcomes, one for each kind of plant, as SVG."""

    def draw(figure: Figure) -> None:
        axes = figure.add_axes((0.17, 0.12, 0.8, 0.70))
        shown = [outcome for outcome in OUTCOMES if any(outcome in each["outcomes"] for each in kinds.values())]
        left = np.zeros(len(kinds))
        for outcome in shown:
            counts = [each["outcomes"].get(outcome, 0) for each in kinds.values()]
            shares = np.array(
                [100.0 * count / each["plants"] for count, each in zip(counts, kinds.values(), strict=True)]
            )
            axes.barh(
                range(len(kinds)), shares, left=left, height=0.62, facecolor=_COLOURS[outcome], edgecolor="white",
                hatch=_HATCHES.get(outcome), linewidth=0, label=outcome,
            )  # fmt: skip
            for row, (share, count) in enumerate(zip(shares, counts, strict=True)):
                if share > 5.0:
                    axes.text(
                        left[row] + share / 2, row, str(count), ha="center", va="center", fontsize=9,
                        color=readable_on(_COLOURS[outcome]),
                    )  # fmt: skip
            left += shares
        axes.set_yticks(range(len(kinds)), list(kinds))
        axes.invert_yaxis()
        axes.set_xlim(0, 100)
        axes.set_xlabel("share of the plants [%]")
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
        axes.legend(
            loc="lower left", bbox_to_anchor=(-0.18, 1.0), ncols=4, handlelength=1.0, columnspacing=1.1, fontsize=9
        )

    return picture(name, draw, _SQUARE)


def calibration_picture(name: str, bins: Sequence[Mapping[str, Any]]) -> str:
    """Return the frequency found over the probability said, with intervals, as SVG."""
    known = [each for each in bins if each["found"]["of"]]

    def draw(figure: Figure) -> None:
        axes = figure.add_axes(_HALF_BOX)
        axes.plot([0, 100], [0, 100], color=MEASURED, linewidth=1.0, linestyle=(0, (4, 3)))
        for each in known:
            said, found = 100 * each["said"], each["found"]
            low, high = (100 * end for end in found["interval"])
            axes.plot([said, said], [low, high], color=CAUSE, linewidth=1.6)
            axes.plot([said], [100 * found["share"]], marker="o", markersize=6, color=CAUSE)
            right = said > 50
            axes.annotate(
                f"{found['of']}", (said, 100 * found["share"]), xytext=(-7 if right else 7, -3),
                textcoords="offset points", ha="right" if right else "left", fontsize=8.5,
            )  # fmt: skip
        axes.set_xlim(0, 102)
        axes.set_ylim(0, 102)
        axes.set_xlabel("probability said [%]")
        axes.set_ylabel("how often it was true [%]")

    return picture(name, draw, _SQUARE)


def share_picture(name: str, shares: Sequence[float]) -> str:
    """Return how many plants have at least a share of the gap closed, as SVG."""

    def draw(figure: Figure) -> None:
        axes = figure.add_axes(_HALF_BOX)
        ordered = np.clip(np.sort(shares)[::-1], 0.0, 1.02)
        part = np.arange(1, len(ordered) + 1) / len(ordered)
        axes.step(np.append(0.0, 100 * part), 100 * np.append(ordered[0], ordered), where="pre", color=CAUSE)
        axes.axvline(90, color=MEASURED, linewidth=1.0, linestyle=(0, (4, 3)))
        axes.text(89, 4, "all but the lowest decile", ha="right", fontsize=8.5, color=INK)
        axes.set_xlim(0, 100)
        axes.set_ylim(0, 104)
        axes.set_xlabel("share of the plants [%]")
        axes.set_ylabel("at least so much of the gap closed [%]")

    return picture(name, draw, _SQUARE)


def seconds_picture(name: str, seconds: Sequence[float]) -> str:
    """Return how many plants took at most some seconds, as SVG."""

    def draw(figure: Figure) -> None:
        axes = figure.add_axes(_HALF_BOX)
        ordered = np.sort(seconds)
        part = np.arange(1, len(ordered) + 1) / len(ordered)
        axes.step(np.append(ordered[0], ordered), 100 * np.append(0.0, part), where="post", color=CAUSE)
        axes.set_xlim(0, None)
        axes.set_ylim(0, 104)
        axes.set_xlabel("seconds of computing on one core, at most")
        axes.set_ylabel("share of the plants [%]")

    return picture(name, draw, _SQUARE)


def confusion_picture(name: str, kind: str, confusion: Mapping[str, Any]) -> str:
    """Return a matrix of counts, a row for each effect that occurs, as SVG.

    Green is right by the rule of the kind; pale green is an alias of what is there, which a declared set may have.
    """
    counts = np.asarray(confusion[kind])
    rows = np.flatnonzero(counts.sum(axis=1))
    columns = np.flatnonzero(counts.sum(axis=0) + np.isin(np.arange(counts.shape[1]), rows))
    shown = counts[np.ix_(rows, columns)]
    row_keys, column_keys = (np.asarray(confusion[side])[used] for side, used in (("rows", rows), ("columns", columns)))
    colour_of = np.array([[_colour(kind, there, said) for said in column_keys] for there in row_keys])
    width, height = 10.2, 1.9 + 0.24 * len(rows)

    def draw(figure: Figure) -> None:
        box = (0.235, 0.05 / height, 0.725, 1 - 1.95 / height)
        axes = figure.add_axes(box)
        share = shown / shown.sum(axis=1, keepdims=True)
        colours = 1.0 - share[..., None] * (1.0 - colour_of)
        axes.imshow(colours, aspect="auto", interpolation="nearest")
        for row, column in zip(*np.nonzero(shown), strict=True):
            axes.text(
                column, row, str(shown[row, column]), ha="center", va="center", fontsize=9,
                color=readable_on(colours[row, column]),
            )  # fmt: skip
        axes.set_yticks(range(len(rows)), [_label(key) for key in row_keys])
        axes.set_xticks(
            range(len(columns)), [_label(key) for key in column_keys], rotation=55, ha="left", rotation_mode="anchor",
        )  # fmt: skip
        axes.xaxis.tick_top()
        axes.tick_params(length=0)
        axes.grid(visible=False)
        for edge in np.arange(-0.5, len(rows)):
            axes.axhline(edge, color="#e6e9ec", linewidth=0.6)
        for edge in np.arange(-0.5, len(columns)):
            axes.axvline(edge, color="#e6e9ec", linewidth=0.6)
        axes.spines[:].set_visible(False)

    return picture(name, draw, (width, height))


_NO_EFFECTS = ("none", "several", "unknown", "failed")


def _colour(kind: str, there: str, said: str) -> tuple[float, ...]:
    """Return the colour of an answer: that of right ones, of aliases, or of wrong ones."""
    from matplotlib.colors import to_rgb

    is_alias = said not in _NO_EFFECTS[1:] and are_aliases(there, said)
    is_right = (said == "unknown" or is_alias) if kind == "left-out" else there == said
    return to_rgb(_COLOURS["right" if is_right else "alias" if is_alias else "wrong"])


def _label(key: str) -> str:
    return key if key in _NO_EFFECTS else effect_title(key)
