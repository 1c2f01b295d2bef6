"""`valvemodel derive`: table, steps, JSON, LaTeX."""

import json
import re
import subprocess
import sys

import pytest
from click.testing import CliRunner

import derivations
from valvemodel.commands.derive import derive
from valvemodel.errors import InputError


def _run(*arguments):
    return CliRunner().invoke(derive, arguments, catch_exceptions=False).output


def test_the_table_fits_a_hundred_columns():
    lines = _run().splitlines()
    assert max(map(len, lines)) <= 100
    assert any(re.match(r" ?27 +sign error +d phi/dx = -", line) for line in lines)


def test_the_steps_of_one_equation():
    output = _run("--equation", "27")
    assert "27: sign error" in output
    assert "1. (25): phi = " in output


def test_an_unknown_equation_is_named():
    with pytest.raises(InputError, match=r"'table-3'.*table-2"):
        CliRunner().invoke(derive, ["--equation", "table-3"], catch_exceptions=False)


def test_only_one_output_at_a_time():
    with pytest.raises(InputError, match="one of --json"):
        CliRunner().invoke(derive, ["--json", "--latex"], catch_exceptions=False)


def test_json_has_the_fields():
    entries = json.loads(_run("--json", "--equation", "31"))
    assert [entry["verdict"] for entry in entries] == ["inherits an error", "not determined", "wrong premise"]
    assert all({"equation", "verdict", "printed", "derived", "steps", "right"} == set(entry) for entry in entries)
    assert all(isinstance(entry["steps"], list) for entry in entries)


def test_latex_is_balanced():
    text = derivations.latex()
    bare = re.sub(r"\\[{}]", "", text)
    assert bare.count("{") == bare.count("}") > 100
    assert text.count(r"\left") == text.count(r"\right")
    for environment in ("align*", "itemize", "cases"):
        assert text.count(f"\\begin{{{environment}}}") == text.count(f"\\end{{{environment}}}") > 0
    assert r"\sigma" in text


def test_the_door_opens_without_sympy():
    code = "import sys, derivations; sys.exit('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
