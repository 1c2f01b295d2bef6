"""The words that sentences of a report are made of: names of effects, lists, likelihoods, text that can be shown."""

from __future__ import annotations

import re
from collections.abc import Sequence

from valvemodel.stages import EFFECTS

DECLARED = {effect.key: effect for effect in EFFECTS}
STAGE_PARTS = {
    "electromagnet": "coil, core and flapper",
    "nozzle": "air supply, nozzle and chamber",
    "stem": "diaphragm, spring, packing and stem",
    "sensor": "linkage and transmitter",
}
"""What a stage is made of, so that a reader knows where to go with a spanner."""

NO_BREAK_SPACE = "\u00a0"
_UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=%|(?:[mµn]?[msNA]|k?Pa|kN)\b)")


def effect_title(key: str) -> str:
    """Return the declared title of an effect, or its key in words where it is not declared."""
    return DECLARED[key].title if key in DECLARED else key.replace("_", " ")


def cause_title(effects: Sequence[str]) -> str:
    """Name a set of effects; the empty set is the base alone."""
    return listed([effect_title(key) for key in effects]) if effects else "the base model alone"


def likelihood(probability: float) -> str:
    """Return the word for a probability."""
    for bound, word in ((0.99, "almost certain"), (0.9, "very likely"), (0.7, "likely")):
        if probability >= bound:
            return word
    if probability >= 0.5:
        return "more likely than not"
    return "possible" if probability >= 0.2 else "unlikely"


def listed(items: Sequence[str], word: str = "and") -> str:
    """Join items as in a sentence: "a, b and c"."""
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {word} {items[-1]}"


def capitalised(text: str) -> str:
    """Return the text with its first letter in upper case and the others as they are."""
    return text[:1].upper() + text[1:]


def tied(text: str) -> str:
    """Put a no-break space between each number and its unit."""
    return _BEFORE_UNIT.sub(NO_BREAK_SPACE, text)


def printable(text: str) -> str:
    """Replace what a file name may hold but no terminal and no UTF-8 file: controls, lone surrogates."""
    return _UNPRINTABLE.sub("\ufffd", text)
