"""The parts that CONTRIBUTING.md adds, each as a file and a line, keep their contracts."""

from __future__ import annotations

import inspect
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

import remanent as rm
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.materials.base import Material
from remanent.models.parts import Part
from tests.contracts import test_drives, test_elements, test_materials
from tests.contracts.public import examples

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
    assert len(BLOCKS) >= len(KINDS)
    for (kind, module), block in zip(KINDS.items(), BLOCKS, strict=False):
        assert len(laws(module)) > 1
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


#: What the text says of each part: its file, and its line in the stub.
FILES = re.findall(r"file\s+`([\w/]+\.py)`", TEXT)
LINES = re.findall(r"`(from \.\S+ import (\w+) as \2)`", TEXT)
#: The table of indicators, and the line and import that the text adds to it.
TABLE = "analysis/regimes/collection.py"
INDICATOR_LINE = re.findall(r'`("\w+": \w+,)`', TEXT)
#: Uses all that was added, where nothing else was changed.
USE = """
import numpy as np
import remanent as rm
from remanent.analysis.regimes.collection import collect_evidence
from remanent.analysis.regimes.long_runs import LongRun
from remanent.results.provenance import read_system

body = rm.Actuator(material=rm.Quadratic(0.1), dissipation=rm.LogarithmicDashpot(0.1))
drive = rm.SineCubed(0.2, 1.25)
ds = rm.steady_extremes(
    body, drive, duration=60.0, discard=30.0, over={"material.stiffening": [0.1, 0.2]}
)
assert (ds.status == rm.Status.OK).all() and (ds["error"] <= 1e-9).all()
history = rm.simulate(body, drive, times=np.linspace(30.0, 60.0, 3001))
inside = history.thickness_stretch
assert abs(float(ds.maximum[0] - inside.max())) < 1e-4 < float(ds.maximum[0] - ds.minimum[0])
assert read_system(history) == body
assert str(rm.classify(body, drive, periods=200).regime.values) == "periodic"

points = (0.1 + 0.6180339887 * np.arange(2001)) % 1.0  # evenly spread over the unit interval
yes, ones = np.array([True]), np.ones((1, 40, 1, 1))
run = LongRun(2000, 50, ones, points[-1:, None], points[None, :, None], ~yes, yes,
              np.array([2000]), np.zeros(1), np.array([2000.0]))
evidence = collect_evidence(run, damped=~yes)
assert abs(float(evidence["scatter"][0]) - 12.0**-0.5) < 1e-3
"""


def test_a_file_and_a_line_are_enough(tmp_path: Path) -> None:
    """In a copy of the package with the files and lines of the text, and no other change."""
    package = tmp_path / "remanent"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(str(rm.__file__)).parent, package, ignore=ignored)
    assert len(FILES) == len(BLOCKS) == len(LINES) + len(INDICATOR_LINE) == 5
    for file, block in zip(FILES, BLOCKS, strict=True):
        assert not (package / file).exists()
        (package / file).write_text(f'"""A new part."""\n\n{block}', encoding="utf-8")
    stub = package / "__init__.pyi"
    with stub.open("a", encoding="utf-8") as text:
        text.writelines(f"{line}\n" for line, _ in LINES)
    table = package / TABLE
    first, module = "INDICATOR_FUNCTIONS: Mapping", "remanent.analysis.regimes.scatter"
    head, tail = table.read_text("utf-8").split(first)
    tail = tail.replace("    {\n", f"    {{\n        {INDICATOR_LINE[0]}\n", 1)
    imports = f"from {module} import scatter\n"
    head = head.replace("from remanent.analysis", f"{imports}from remanent.analysis", 1)
    table.write_text(f"{head}{first}{tail}", encoding="utf-8")
    finished = subprocess.run(
        [sys.executable, "-W", "error", "-c", USE],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr
