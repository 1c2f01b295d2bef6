"""The plants share no code with the toolkit that is judged with them."""

import ast
from pathlib import Path

import pytest

import diagnosis.blindtest.plants as plants

FOLDER = Path(plants.__file__).parent
FILES = [
    FOLDER / f"{name}.py" for name in ("plants", "profiles", "truth", "formulations", "valve", "severity")
] + sorted((FOLDER / "chain").glob("*.py"))
OWN = "diagnosis.blindtest"


def imported(path: Path) -> set[str]:
    modules = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} imports relatively"
            modules.add(str(node.module))
    return modules


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_file_imports_no_toolkit(path: Path):
    for module in imported(path):
        room = module.split(".")[0]
        assert room not in {"valvemodel", "identification", "derivations"}
        assert room != "diagnosis" or module.startswith(OWN)
