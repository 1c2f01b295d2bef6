"""The library's reference: what the public doors export, from the docstrings."""

from __future__ import annotations

from importlib import import_module

import mkdocs_gen_files

DOORS = ("valvemodel", "identification", "diagnosis", "derivations")

with mkdocs_gen_files.open("reference.md", "w") as page:
    page.write("# Library reference\n\nEverything is SI inside. Names not listed here are private.\n")
    for door in DOORS:
        module = import_module(door)
        first = (module.__doc__ or "").strip().splitlines()[0]
        page.write(f"\n# `{door}`\n\n{first}\n")
        for name in module.__all__:
            home = getattr(getattr(module, name), "__module__", door)
            page.write(f"\n::: {home}.{name}\n")
