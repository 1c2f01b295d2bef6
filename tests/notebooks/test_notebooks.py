"""Every notebook runs from clean, shows what it showed, is quick and small, and goes through the public doors."""

import ast
import re
import time
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
ROOMS = {"derivations", "valvemodel", "identification", "diagnosis", "benchmarks", "tests"}
DOORS = {
    "derivations", "valvemodel", "valvemodel.control", "valvemodel.linear", "identification", "identification.design",
    "diagnosis", "diagnosis.trials",
}  # fmt: skip
LONGEST = 60.0
"""What a notebook may take. [s]"""

LARGEST = 300_000
"""What a notebook may weigh. [byte]"""

NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


def name_of(path: Path) -> str:
    return path.stem


def code_of(path: Path) -> list:
    return [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]


def shown(cell) -> list[str]:
    """What a cell shows and in which forms, its numbers masked: they may differ in the last digit elsewhere.

    How often a stream is flushed on the way is a matter of time: what follows on the same stream is one text.
    """
    texts: list[str] = []
    stream = None
    for output in cell.outputs:
        data = output.get("data", {})
        text = " ".join(NUMBER.sub("#", output.get("text") or data.get("text/plain", "")).split())
        if stream is not None and output.get("name") == stream:
            texts[-1] += " " + text
        else:
            texts.append(" ".join([output.output_type, *sorted(data), text]))
        stream = output.get("name")
    return texts


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_runs_and_shows_what_it_showed(path: Path):
    notebook = nbformat.read(path, 4)
    stored = [shown(cell) for cell in notebook.cells if cell.cell_type == "code"]
    began = time.perf_counter()
    client = NotebookClient(notebook, timeout=5 * LONGEST, resources={"metadata": {"path": str(path.parent)}})
    client.execute()
    took = time.perf_counter() - began
    assert [shown(cell) for cell in notebook.cells if cell.cell_type == "code"] == stored
    assert took < 3 * LONGEST, f"{took:.0f} s"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_is_small_and_says_nothing_on_the_error_stream(path: Path):
    assert path.stat().st_size < LARGEST
    outputs = [output for cell in code_of(path) for output in cell.outputs]
    assert outputs, "a reader of the repository page sees what it shows"
    assert all(output.get("name") != "stderr" and output.output_type != "error" for output in outputs)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_goes_through_the_public_doors(path: Path):
    for cell in code_of(path):
        for node in ast.walk(ast.parse(cell.source)):
            names = [node.module] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                assert name.split(".")[0] not in ROOMS or name in DOORS, f"{path.name} imports {name}"


def test_all_are_listed():
    listed = (ROOT / "notebooks" / "README.md").read_text(encoding="utf-8")
    assert all(f"({path.name})" in listed for path in NOTEBOOKS)
    assert [path.stem[0] for path in NOTEBOOKS] == list("1234567")
