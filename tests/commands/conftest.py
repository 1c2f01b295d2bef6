"""A short record and a way to run the command line as a user does."""

from pathlib import Path

import pytest
from click.testing import CliRunner

SHORT_ROWS = 1500


@pytest.fixture(scope="session")
def demo_record() -> Path:
    """The bundled record, 150 s."""
    return Path(__file__).resolve().parents[2] / "diagnosis" / "examples" / "demo.csv"


@pytest.fixture(scope="session")
def short_record(demo_record, tmp_path_factory) -> Path:
    """The first 30 s of the bundled record."""
    path = tmp_path_factory.mktemp("records") / "short.csv"
    lines = demo_record.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[: SHORT_ROWS + 1]))
    return path


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Run `valvemodel ...` in an empty folder; give back what click's runner gives."""
    from valvemodel.commands import command_line

    monkeypatch.chdir(tmp_path)

    def run(*words):
        return CliRunner().invoke(command_line, [str(word) for word in words])

    return run
