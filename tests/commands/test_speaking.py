"""How commands speak: quiet when told so, JSON for machines, plain without colour, and completed by the shell."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from importlib import import_module, metadata

import pytest
from click.testing import CliRunner

from valvemodel.commands import COMMANDS, command_line
from valvemodel.stages import EFFECTS
from valvemodel.valves import valve_names

SPEAKING = ["effects", "effects coil_lag", "valves", "valves table2", "simulate --input {record} --out out.csv"]


def run(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command line as a process of its own."""
    line = [sys.executable, "-m", "valvemodel", *words]
    return subprocess.run(line, capture_output=True, text=True, env=os.environ | environment, check=False)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_can_keep_quiet(name):
    options = [
        option for each in getattr(import_module(f"valvemodel.commands.{name}"), name).params for option in each.opts
    ]
    assert options.count("--quiet") == 1


@pytest.mark.parametrize("line", SPEAKING)
def test_quiet_command_prints_nothing(command, short_record, line):
    words = line.format(record=short_record).split()
    assert command(*words).output
    quiet = command(*words, "--quiet")
    assert (quiet.exit_code, quiet.output) == (0, "")


@pytest.mark.parametrize("line", ["valves nope", "effects nope", "simulate --input nope.csv --out out.csv", "simulate"])
def test_quiet_command_still_says_what_is_wrong(command, line):
    loud, quiet = command(*line.split()), command(*line.split(), "--quiet")
    assert loud.exit_code == quiet.exit_code == 2
    assert quiet.output == loud.output != ""


def test_json_and_quiet_exclude_each_other(command):
    result = command("effects", "--json", "--quiet")
    assert result.exit_code == 2
    assert "exclude each other" in result.output


def test_json_is_alone_on_standard_output(command, short_record, tmp_path):
    command("simulate", "--input", short_record, "--out", tmp_path / "out.csv")
    asked = {
        "fit": ("fit", tmp_path / "out.csv", "--out", tmp_path / "fitted"),
        "move": ("move", "--to", "120 mm", "--out", tmp_path / "move.csv"),
    }
    for name, words in asked.items():
        result = command(*words, "--json")
        assert result.exit_code == 0, result.output
        assert json.loads(result.stdout)["schema"].startswith(f"valvemodel.{name}/")


def test_version_is_that_of_the_package():
    assert run("--version").stdout == f"valvemodel {metadata.version('valvemodel')}\n"


def test_colour_is_only_where_it_is_wanted():
    colour = "\x1b[33m"
    assert colour not in run("valves").stdout
    assert colour in run("valves", FORCE_COLOR="1", TERM="xterm").stdout
    assert colour not in run("valves", FORCE_COLOR="1", TERM="xterm", NO_COLOR="1").stdout


PREFIX = {"bash": "plain,", "zsh": "", "fish": "plain,"}


def completed(shell: str, *words: str) -> list[str]:
    """Return what a shell is offered for the last of some words, by click's own protocol."""
    line = " ".join(["valvemodel", *words])
    last = words[-1] if shell == "fish" else str(len(words))
    asked = {"COMP_WORDS": line, "COMP_CWORD": last, "_VALVEMODEL_COMPLETE": f"{shell}_complete"}
    done = CliRunner().invoke(command_line, [], prog_name="valvemodel", env=asked)
    return [each.partition("\t")[0].removeprefix(PREFIX[shell]) for each in done.stdout.splitlines()]


@pytest.mark.parametrize("shell", PREFIX)
def test_shell_completes_commands_options_and_values(shell):
    assert "diagnose" in completed(shell, "di")
    assert "--effect" in completed(shell, "simulate", "--ef")
    keys = [effect.key for effect in EFFECTS if effect.key.startswith("s")]
    for words in (
        ("effects", "s"),
        ("simulate", "--effect", "s"),
        ("fit", "--effect", "s"),
        ("blindtest", "--only", "s"),
    ):
        assert [each for each in completed(shell, *words) if each in keys] == keys
    assert set(valve_names()) <= set(completed(shell, "simulate", "--valve", ""))
    assert "table2" in completed(shell, "valves", "t")


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_takes_the_script(tmp_path, monkeypatch):
    program = (
        'eval "$(_VALVEMODEL_COMPLETE=bash_source valvemodel)"\n'
        "COMP_WORDS=(valvemodel effects coil) COMP_CWORD=2\n"
        "_valvemodel_completion valvemodel\n"
        'echo "${COMPREPLY[@]}"\n'
    )
    (tmp_path / "valvemodel").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m valvemodel "$@"\n')
    (tmp_path / "valvemodel").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["coil_lag"], done.stderr


@pytest.mark.parametrize("shell", PREFIX)
def test_script_for_each_shell_is_printed(shell):
    done = run(_VALVEMODEL_COMPLETE=f"{shell}_source")
    assert "_valvemodel_completion" in done.stdout
