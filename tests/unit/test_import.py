"""The public names: cheap to import, all there, and visible to tools."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import remanent

HEAVY = ("numpy", "scipy", "sympy", "matplotlib", "xarray", "llvmlite", "pint")


def run(code: str) -> str:
    """Run code in a fresh interpreter and return what it printed."""
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.strip()


def test_import_loads_nothing_heavy() -> None:
    """Importing the package, listing it and reading its names' table costs no library."""
    loaded = run("import sys, remanent; dir(remanent); print(*sys.modules)").split()
    assert "remanent" in loaded
    assert not set(HEAVY) & set(loaded)


def test_errors_need_no_library() -> None:
    """A caller can name the exceptions without paying for the computation."""
    loaded = run("import sys; from remanent import InputError; print(*sys.modules)").split()
    assert not set(HEAVY) & set(loaded)


@pytest.mark.parametrize("name", remanent.__all__)
def test_every_public_name_resolves(name: str) -> None:
    """Each name in ``__all__`` is there, is listed, and is the same object each time."""
    first = getattr(remanent, name)
    assert first is getattr(remanent, name)
    assert name in dir(remanent)


def test_star_import_gives_all_names() -> None:
    """``from remanent import *`` gives exactly ``__all__``."""
    names = run("from remanent import *; print(*sorted(n for n in dir() if n != '__builtins__'))")
    module_names = {"__name__", "__doc__", "__package__", "__loader__", "__spec__"}
    found = set(names.split()) - module_names - {"__annotations__", "__file__", "__cached__"}
    assert found == set(remanent.__all__)


def test_every_name_of_the_stub_is_exported_to_type_checkers() -> None:
    """A stub re-exports only what it imports under its own name; else tools do not see it."""
    stub = Path(str(remanent.__file__)).with_suffix(".pyi")
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    aliases = [
        alias for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names
    ]
    assert all(alias.asname == alias.name for alias in aliases)
    names = {alias.name for alias in aliases} - {"plots"}
    assert names | {"plot", "__version__"} == set(remanent.__all__)
    assert len(aliases) == len({alias.name for alias in aliases})


def test_unknown_name_raises() -> None:
    """A name that does not exist is an AttributeError that says so."""
    with pytest.raises(AttributeError, match="No remanent attribute no_such_name"):
        _ = remanent.no_such_name  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"Did you mean `simulate`\?"):
        _ = remanent.simulat  # type: ignore[attr-defined]


def test_only_public_names_are_listed() -> None:
    """``dir`` lists the public names, and not what the package itself imports."""
    assert {name for name in dir(remanent) if not name.startswith("__")} <= set(remanent.__all__)


def test_the_package_runs_as_a_module() -> None:
    """``python -m remanent`` is the command ``remanent``."""
    shown = subprocess.run(
        [sys.executable, "-m", "remanent", "--help"], check=True, capture_output=True, text=True
    ).stdout
    assert "Usage: python -m remanent" in shown
    assert "explore" in shown
