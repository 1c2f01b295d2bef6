"""What the house says of itself is true: README, notebooks, versions, and nothing of one machine."""

import importlib.util
import json
import re
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

import click
import pytest

from valvemodel.commands import COMMANDS, command_line

ROOT = Path(__file__).resolve().parents[1]
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "notebooks/README.md",
    "diagnosis/examples/README.md",
)
PLAIN = (*PAGES, "Makefile", ".ci/run", "constraints.txt", "pyproject.toml", "LICENSE")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PLAIN)
def test_nothing_is_of_one_machine(name: str):
    for line in text_of(name).splitlines():
        assert not re.search(r"(?<![\w.])/(home|root|work|tmp|Users|mnt)/", line), line
        assert not re.search(r"\b(index-url|trusted-host|--hash|file://|localhost)\b", line), line
        for address in re.findall(r"https?://([^/\s)]+)", line):
            assert address in {"keepachangelog.com"}, line


def test_make_targets_of_the_readme_exist():
    readme, makefile = text_of("README.md"), text_of("Makefile")
    targets = set(re.findall(r"\bmake (\w+)", readme))
    assert {"demo", "test"} <= targets
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def commands_in(page: str) -> list[list[str]]:
    """Return the words of every `valvemodel ...` line of the indented code of a page."""
    lines = re.findall(r"^(?: {4}|\$ )(valvemodel [a-z].*)$", text_of(page), re.MULTILINE)
    return [line.split("#")[0].split() for line in lines]


@pytest.mark.parametrize("page", [page for page in PAGES if page.endswith(".md")])
def test_commands_of_a_page_exist_with_their_options(page: str):
    found = commands_in(page)
    assert found or page not in ("README.md", "diagnosis/examples/README.md")
    for _, name, *words in found:
        command = command_line.get_command(click.Context(command_line), name)
        options = {option for each in command.params for option in each.opts}
        for word in words:
            assert not word.startswith("--") or word in options, f"{page}: {name} has no {word}"


def test_readme_lists_every_command_and_every_room():
    readme = text_of("README.md")
    for name in COMMANDS:
        assert f"`valvemodel {name}" in readme, name
    for room in (
        "derivations",
        "valvemodel",
        "identification",
        "diagnosis",
        "notebooks",
        "benchmarks",
        "tests",
    ):
        assert f"{room}/" in readme, room


def test_paths_of_the_pages_exist():
    for page in ("README.md", "CONTRIBUTING.md"):
        for path in re.findall(
            r"`((?:derivations|valvemodel|identification|diagnosis|notebooks|benchmarks|tests)/[\w./-]+)`",
            text_of(page),
        ):
            assert (ROOT / path).exists(), f"{page} names {path}"


def test_constraints_pin_every_dependency_exactly():
    pins = dict(line.split("==") for line in text_of("constraints.txt").split())
    names = {name.lower().replace("_", "-") for name in pins}
    wanted = [*PROJECT["dependencies"], *chain(*PROJECT["optional-dependencies"].values())]
    for requirement in wanted:
        assert re.match(r"[\w-]+", requirement)[0].lower() in names, requirement


def test_version_is_the_same_everywhere():
    version = PROJECT["version"]
    assert f"## [{version}]" in text_of("CHANGELOG.md")
    assert f"version: {version}" in text_of("CITATION.cff")


def test_help_starts_without_the_heavy_libraries():
    program = (
        "import json, sys, runpy\n"
        "sys.argv = ['valvemodel', '--help']\n"
        "try: runpy.run_module('valvemodel', run_name='__main__')\n"
        "except SystemExit: pass\n"
        "print(json.dumps(sorted(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT)
    assert "diagnose" in done.stdout
    loaded = set(json.loads(done.stderr))
    for heavy in ("numpy", "numba", "polars", "sympy", "scipy", "pint", "matplotlib", "pandas", "rich"):
        assert heavy not in loaded, heavy


def test_map_of_the_repository_is_what_the_packages_say():
    spec = importlib.util.spec_from_file_location("map_of_repository", ROOT / "docs" / "map.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.drawn() in text_of("README.md"), "run `python docs/map.py`"


@pytest.mark.parametrize("page", [page for page in PAGES if page.endswith(".md")])
def test_links_of_a_page_lead_somewhere(page: str):
    folder = (ROOT / page).parent
    for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        place, _, anchor = target.partition("#")
        if not place.startswith("https://"):
            assert (folder / place).exists() if place else True, f"{page} links to {target}"
        if anchor and not place:
            assert re.search(rf"^#+ {anchor}$", text_of(page), re.MULTILINE | re.IGNORECASE), (
                f"{page} links to {target}"
            )


def test_picture_of_the_readme_is_light():
    pictures = re.findall(r"!\[[^\]]{40,}\]\((docs/pictures/[\w.]+)\)", text_of("README.md"))
    assert pictures, "the README shows a diagnosis, and says what it shows"
    for picture in pictures:
        assert (ROOT / picture).stat().st_size < 60_000


def test_every_command_has_its_page():
    assert {path.stem for path in (ROOT / "docs" / "how_to").glob("*.md")} == set(COMMANDS)
