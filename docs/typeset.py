"""Makes pages that ask the network for nothing: `$...$` and `$$...$$` become MathML, foreign scripts are left out."""

from __future__ import annotations

import re
from typing import Any

from latex2mathml.converter import convert

CODE = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)
BLOCK = re.compile(r"\$\$(.+?)\$\$", re.DOTALL)
FOREIGN = re.compile(r"<script[^>]*src=\"?https?://[^>]*></script>")
INLINE = re.compile(r"(?<![\\$\w])\$([^$\n]+?)\$(?![\w$])")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace the formulas of a page, but not those in code."""
    parts = CODE.split(markdown)
    return "".join(part if part.startswith("`") else typeset(part) for part in parts)


def on_post_page(output: str, **_: Any) -> str:
    """Leave out scripts from other places."""
    return FOREIGN.sub("", output)


def on_post_template(output_content: str, **_: Any) -> str:
    """Leave them out of pages that are made without Markdown, too."""
    return FOREIGN.sub("", output_content)


def typeset(text: str) -> str:
    """Replace the formulas of a text."""
    text = BLOCK.sub(lambda found: f"\n{mathml(found[1], display='block')}\n", text)
    return INLINE.sub(lambda found: mathml(found[1]), text)


def mathml(formula: str, display: str = "inline") -> str:
    """Return the MathML of a LaTeX formula, on one line."""
    spoken = formula.replace('"', "'").replace("<", "&lt;").replace("\n", " ").strip()
    element = convert(formula.strip().replace(r"\,", r"\;"), display=display)
    return element.replace("<math ", f'<math alttext="{spoken}" ', 1).replace("\n", " ")
