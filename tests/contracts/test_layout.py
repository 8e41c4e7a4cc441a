"""What files may import, beside the layers that import-linter holds; tests state their laws."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import is_dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import grimp

import remanent
from tests.adequacy.core import core_files

#: Objects that learn from call to call, and whose docstrings say what changes.
LEARNING = {"BlockAdvancer", "CoarseReplay", "_CurveArm", "_MeasureEvaluation"}
#: The table of public names.
STUB = Path(str(remanent.__file__)).with_suffix(".pyi")
#: The folder of all tests.
TESTS = Path(__file__).parents[1]


@cache
def imports() -> dict[str, frozenset[str]]:
    """Every file of the package with the files that it imports, for type checkers too."""
    graph = grimp.build_graph("remanent", cache_dir=None)
    return {m: frozenset(graph.find_modules_directly_imported_by(m)) for m in graph.modules}


def verb_files() -> set[str]:
    """The files of studies in which public functions are defined."""
    nodes = ast.parse(STUB.read_text(encoding="utf-8")).body
    return {
        f"remanent.{node.module}"
        for node in nodes
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("studies.")
        if any(alias.name.islower() for alias in node.names)
    }


def defined_tests(path: Path) -> list[ast.FunctionDef]:
    """The test functions of a file."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [n for n in nodes if isinstance(n, ast.FunctionDef) and n.name.startswith("test_")]


def circle(graph: dict[str, frozenset[str]]) -> list[str]:
    """Files that import each other in a circle; none where there is no circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return [str(module) for module in error.args[1]]
    return []


def test_no_files_import_each_other_in_a_circle() -> None:
    """The import graph of the whole package is acyclic; a circle of two would be seen."""
    assert len(imports()) > 100
    assert circle({"a": frozenset("b"), "b": frozenset("a")})
    assert circle(imports()) == []


def test_a_verb_imports_no_other_verb() -> None:
    """What two verbs need stands in a private file, or on a floor below: each can be read
    and changed without the others."""
    verbs = verb_files()
    assert "remanent.studies.regimes.classify" in verbs
    borrowed = {
        (verb, imported) for verb in verbs for imported in imports()[verb] if imported in verbs
    }
    assert borrowed == set()


def test_a_verb_stands_in_a_file_of_its_name() -> None:
    """A room is a list of verbs: `rm.name` is found in `name.py`."""
    assert len(verb_files()) > 20
    for verb in verb_files():
        assert hasattr(remanent, verb.rpartition(".")[2]), verb


def core_classes() -> Iterator[type]:
    """The classes that files of the numeric core define."""
    for file in core_files():
        name = f"remanent/{file.removesuffix('.py').removesuffix('/__init__')}".replace("/", ".")
        for value in vars(import_module(name)).values():
            if isinstance(value, type) and value.__module__ == name:
                yield value


def test_values_of_the_numeric_core_do_not_change() -> None:
    """Every dataclass is frozen, but for the few that learn."""
    values = [value for value in core_classes() if is_dataclass(value)]
    assert len(values) > 100
    changing = {v.__name__ for v in values if not v.__dataclass_params__.frozen}  # type: ignore[attr-defined]
    assert changing == LEARNING


def test_every_test_states_its_law() -> None:
    """A test has a docstring: what must hold, so that a failure can be understood."""
    tests = [(path, test) for path in TESTS.rglob("*.py") for test in defined_tests(path)]
    assert len(tests) > 700
    without = [f"{path.name}::{test.name}" for path, test in tests if not ast.get_docstring(test)]
    assert without == []
