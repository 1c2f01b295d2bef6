"""The rooms stand in one order, and imports run down it only."""

import ast
import importlib
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = ("derivations", "valvemodel", "identification", "diagnosis", "benchmarks", "notebooks")
"""Each may import what stands before it, and itself."""

FILES = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
COMMANDS = ROOT / "valvemodel" / "commands"
PLANTS = ROOT / "diagnosis" / "blindtest"
START_UP = {
    "numpy",
    "numba",
    "polars",
    "sympy",
    "scipy",
    "casadi",
    "control",
    "pint",
    "matplotlib",
    "jinja2",
    "rich",
    "pandas",
}
DOORS = (
    "valvemodel",
    "valvemodel.control",
    "valvemodel.linear",
    "valvemodel.records",
    "valvemodel.valves",
    "derivations",
    "identification.design",
    "identification.inverse_dynamics",
    "identification",
    "diagnosis",
    "diagnosis.report",
    "diagnosis.trials",
)


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def outer_imports(tree: ast.AST) -> Iterator[tuple[str, list[str], int]]:
    """Yield module, names and line of the imports that run when the file is imported."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        yield from own_imports(node)
        yield from outer_imports(node)


def all_imports(tree: ast.AST) -> Iterator[tuple[str, list[str], int]]:
    for node in ast.walk(tree):
        yield from own_imports(node)


def own_imports(node: ast.AST) -> Iterator[tuple[str, list[str], int]]:
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield alias.name, [], node.lineno
    elif isinstance(node, ast.ImportFrom):
        assert node.level == 0, "imports name their room"
        yield str(node.module), [alias.name for alias in node.names], node.lineno


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_imports_run_one_way(path: Path):
    room = path.relative_to(ROOT).parts[0]
    allowed = ROOMS[: ROOMS.index(room) + 1]
    imports = outer_imports if path.is_relative_to(COMMANDS) else all_imports
    for module, _, line in imports(tree_of(path)):
        target = module.split(".")[0]
        assert target not in ROOMS or target in allowed, f"{name_of(path)}:{line} imports {module}"
        assert target != "tests", f"{name_of(path)}:{line} imports the tests"


@pytest.mark.parametrize("room", ["identification", "diagnosis"])
def test_rooms_within_a_room_stand_in_an_order(room: str):
    inner = {path.parent.name for path in (ROOT / room).glob("*/__init__.py")}
    below: dict[str, set[str]] = {name: set() for name in inner}
    for name in inner:
        for path in (ROOT / room / name).rglob("*.py"):
            targets = {
                module.split(".")[1] for module, _, _ in all_imports(tree_of(path)) if module.startswith(f"{room}.")
            }
            below[name] |= targets & inner - {name}
    assert any(below.values())
    assert len(list(TopologicalSorter(below).static_order())) == len(inner)


def test_plants_import_nothing_of_the_toolkit():
    files = sorted(PLANTS.rglob("*.py"))
    assert files
    for path in files:
        for module, _, line in all_imports(tree_of(path)):
            target = module.split(".")[0]
            is_own = module.startswith("diagnosis.blindtest")
            assert target not in ROOMS or is_own, f"{name_of(path)}:{line} imports {module}"


@pytest.mark.parametrize("path", sorted(COMMANDS.glob("*.py")), ids=name_of)
def test_commands_load_nothing_heavy(path: Path):
    for module, _, line in outer_imports(tree_of(path)):
        assert module.split(".")[0] not in START_UP, f"{name_of(path)}:{line} imports {module} at start-up"


@pytest.mark.parametrize("library", ["matplotlib", "pandas"])
def test_libraries_of_figures_and_tables_load_where_one_is_made(library: str):
    for path in FILES:
        modules = [module for module, _, _ in outer_imports(tree_of(path))]
        assert not any(module.split(".")[0] == library for module in modules), name_of(path)


@pytest.mark.parametrize("door", DOORS)
def test_door_offers_what_it_says(door: str):
    package = importlib.import_module(door)
    names = package.__all__
    assert names == sorted(names), f"{door}.__all__ is sorted"
    for name in names:
        assert getattr(package, name).__doc__, f"{door}.{name} says what it is"


def test_unknown_name_at_the_door_is_an_attribute_error():
    import valvemodel

    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = valvemodel.simulat
    assert "simulate" in dir(valvemodel)


def test_every_package_has_a_file_that_says_what_it_answers():
    folders = {path.parent for path in FILES if not path.is_relative_to(ROOT / "notebooks")}
    for folder in folders:
        assert (folder / "__init__.py").exists(), f"{name_of(folder)} is no package"


@pytest.mark.parametrize(
    "path",
    [path for path in FILES if path.name not in ("__init__.py",) and "notebooks" not in path.parts],
    ids=name_of,
)
def test_file_says_in_one_line_what_is_inside(path: Path):
    docstring = ast.get_docstring(tree_of(path))
    assert docstring, f"{name_of(path)} has no docstring"
    assert path.stem not in {"utils", "helpers", "core", "base", "common", "misc", "manager"}
