"""The glossary: every letter of the paper with its name in the code, unit, meaning and sign."""

from __future__ import annotations

import mkdocs_gen_files

from derivations.glossary import LETTERS


def cell(text: str) -> str:
    return text.replace("|", "\\|").replace("_", "\\_").replace("*", "\\*")


with mkdocs_gen_files.open("glossary.md", "w") as page:
    page.write("# Glossary\n\n")
    page.write("| letter in the paper | name in the code | unit | meaning | sign |\n|---|---|---|---|---|\n")
    for letter in LETTERS.values():
        unit = "" if letter.unit == "1" else letter.unit
        page.write(
            f"| {cell(letter.label)} | `{letter.name}` | {unit} | {cell(letter.meaning)} | {cell(letter.sign)} |\n"
        )
