"""SVG for a page: what matplotlib draws, without anything that a page must not hold."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK, GRID = "#222222", "#dddddd"
HALF, WIDE = (5.0, 3.6), (10.2, 3.4)
"""Sizes of pictures for half a page (and a phone) and for the whole width. [in]"""
SETTINGS: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "valvemodel",
    "text.parse_math": False,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.edgecolor": "#666666",
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "path.simplify": True,
    "path.simplify_threshold": 0.25,
}
_PAGE_FONT = "system-ui, -apple-system, 'Segoe UI', Helvetica, Arial, sans-serif"


def picture(name: str, draw: Callable[[Figure], None], size: tuple[float, float] = HALF) -> str:
    """Draw on a new figure and return it as SVG markup without anything that a page must not hold.

    Parameters
    ----------
    name : str
        Prefix of the ids in the markup, different for each picture of a page.
    draw : callable
        Draws on the figure that it is given.
    size : tuple of float
        Width and height. [in]
    """
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=size)
        figure.patch.set_visible(False)
        draw(figure)
        buffer = io.StringIO()
        with warnings.catch_warnings():
            # a label in another script: the page's fonts have the glyph, matplotlib's need not
            warnings.filterwarnings("ignore", message="Glyph .* missing")
            figure.savefig(buffer, format="svg", metadata={"Date": None})
    return _inline(buffer.getvalue(), name)


def readable_on(colour: Any) -> str:
    """Return black or white, whichever stands out more on a colour; either is at least 4.5 times as bright or dark."""
    from matplotlib.colors import to_rgb

    channels = [each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in to_rgb(colour)]
    luminance = sum(weight * each for weight, each in zip((0.2126, 0.7152, 0.0722), channels, strict=True))
    return "black" if (luminance + 0.05) ** 2 > 0.05 * 1.05 else "white"


def equation_picture(name: str, equation: str) -> str:
    """Typeset a LaTeX equation as SVG markup, or return an empty text where matplotlib cannot."""
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.mathtext import MathTextParser

    text = re.sub(r"\\(le|ge)(?![a-zA-Z])", r"\\\1q", equation)
    text = re.sub(r"\\text\{([^{}]*)\}", lambda words: _roman(words[1]), text)
    text = f"${text}$"
    try:
        with matplotlib.rc_context({"svg.fonttype": "path", "svg.hashsalt": "valvemodel", "mathtext.fontset": "cm"}):
            parser = MathTextParser("path")
            width, height, depth, *_ = parser.parse(text, dpi=72)
            scale = 12.0 / 10.0
            box = ((width * scale + 6) / 72, (height * scale + 6) / 72)
            figure = Figure(figsize=box)
            figure.patch.set_visible(False)
            figure.text(0.5, (depth * scale + 3) / 72 / box[1], text, ha="center", va="baseline", fontsize=12)
            buffer = io.StringIO()
            figure.savefig(buffer, format="svg", metadata={"Date": None})
    except ValueError:
        return ""
    return _inline(buffer.getvalue(), name, keeps_size=True)


def _roman(words: str) -> str:
    return r"\ \mathrm{" + words.strip().replace(" ", r"\ ") + "}" + (r"\ " if words.endswith(" ") else "")


def _inline(markup: str, name: str, *, keeps_size: bool = False) -> str:
    markup = markup[markup.index("<svg") :]
    markup = re.sub(r"<metadata>.*?</metadata>|<style[^>]*>.*?</style>|<!--.*?-->", "", markup, flags=re.DOTALL)
    head, _, rest = markup.partition(">")
    view = re.search(r'viewBox="[^"]*"', head)
    size = re.search(r'width="([\d.]+)pt"', head)
    assert view is not None
    assert size is not None
    width = f' style="width: {float(size[1]) / 10:.2f}em"' if keeps_size else ""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {view[0]}{width}'
    rest = rest.replace(' xlink:href="#', ' href="#').replace("'DejaVu Sans', sans-serif", _PAGE_FONT)
    rest = re.sub(r'( id="|url\(#| href="#)', rf"\g<1>{name}-", rest)
    rest = re.sub(r"[ \t]*\n[ \t]*", "\n", rest).strip()
    return f'{head} aria-hidden="true" focusable="false">{rest}'
