"""The parts that CONTRIBUTING.md adds, each as a file and a line, keep their contracts."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from tests.contracts import test_drives, test_elements, test_materials
from tests.contracts.public import examples

import remanent as rm
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.models.parts import Part

TEXT = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text("utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
KINDS: dict[type[Part], ModuleType] = {
    Material: test_materials,
    Dissipation: test_elements,
    Drive: test_drives,
}


def added(block: str, monkeypatch: pytest.MonkeyPatch) -> tuple[str, type[Part]]:
    """The class that a block defines, made public under its name, as its line would do."""
    (name,) = re.findall(r"^class (\w+)\(", block, re.MULTILINE)
    module = ModuleType(f"new_part_{name.lower()}")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    exec(compile(block, "CONTRIBUTING.md", "exec"), module.__dict__)  # noqa: S102
    part: type[Part] = getattr(module, name)
    monkeypatch.setattr(rm, name, part, raising=False)
    monkeypatch.setattr(rm, "__all__", [*rm.__all__, name])
    return name, part


def laws(module: ModuleType) -> dict[str, Callable[[Part], None]]:
    """The contract tests that take a part and nothing else, by name."""
    functions = inspect.getmembers(module, inspect.isfunction)
    return {
        name: law
        for name, law in functions
        if name.startswith("test_")
        and [*inspect.signature(law).parameters] in (["material"], ["element"], ["drive"])
    }


#: Laws that are about materials with a limiting stretch, or drives of another kind.
CONDITIONAL = ("beyond_the_limit",)


def test_there_is_one_block_for_each_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    """A material, an element and a drive, each of which `examples` finds by itself."""
    for kind, block in zip(KINDS, BLOCKS, strict=True):
        name, part = added(block, monkeypatch)
        assert isinstance(examples(kind)[name], part)


@pytest.mark.parametrize(
    ("kind", "law"),
    [
        pytest.param(kind, law, id=f"{kind.__name__}, {law}")
        for kind, module in KINDS.items()
        for law in laws(module)
        if not any(words in law for words in CONDITIONAL)
    ],
)
def test_a_new_part_keeps_its_contract(
    kind: type[Part], law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every law of its kind holds for the part that the block defines."""
    block = BLOCKS[[*KINDS].index(kind)]
    _, part = added(block, monkeypatch)
    laws(KINDS[kind])[law](part.example())
