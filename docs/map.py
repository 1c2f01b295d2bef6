"""The map of the repository in README.md, made from the packages' own first lines (`python docs/map.py`)."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("derivations", "valvemodel", "identification", "diagnosis", "benchmarks")
OTHERS = {
    "notebooks/": "How do I explain it? Notebooks that the tests run, through the public doors only.",
    "docs/": "Where do I read on? The documentation site that `make docs` builds.",
    "tests/": "How do we know?",
}
"""Folders that are no packages."""

OPENING, CLOSING = "<!-- map: python docs/map.py -->", "<!-- end of map -->"
WIDTH = 22


def first_line(package: Path) -> str:
    """Return the first line of what a package says of itself."""
    docstring = ast.get_docstring(ast.parse((package / "__init__.py").read_text(encoding="utf-8")))
    assert docstring, f"{package} says nothing of itself"
    return docstring.splitlines()[0]


def lines_of(package: Path, depth: int) -> list[str]:
    """Return a line for a package and, below it, for those within it."""
    name = "  " * depth + package.name + "/"
    lines = [f"{name:{WIDTH}s}{first_line(package)}"]
    for inner in sorted(package.iterdir()):
        if depth < 1 and (inner / "__init__.py").exists():
            lines += lines_of(inner, depth + 1)
    return lines


def drawn() -> str:
    """Return the block as it stands in README.md."""
    lines = [line for room in ROOMS for line in lines_of(ROOT / room, 0)]
    lines += [f"{name:{WIDTH}s}{what}" for name, what in OTHERS.items()]
    return "\n".join([OPENING, "```text", *lines, "```", CLOSING])


def main() -> None:
    """Renew the block in README.md."""
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    before, rest = text.split(OPENING)
    after = rest.split(CLOSING)[1]
    readme.write_text(before + drawn() + after, encoding="utf-8")


if __name__ == "__main__":
    main()
