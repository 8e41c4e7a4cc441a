"""Which tests run a line, from the contexts that ``make coverage`` records."""

from __future__ import annotations

import ast
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Final

from coverage import CoverageData

from tests.adequacy.core import PACKAGE, ROOT

#: Tests that hold what runs at import, of every file: decorators, and defaults of arguments.
_OF_EVERY_FILE: Final = (
    "tests/contracts/test_layout.py::test_values_of_the_numeric_core_do_not_change",
    "tests/contracts/test_signatures.py::test_arguments_and_defaults_are_those_promised",
)


@dataclass(frozen=True)
class CoveringTests:
    """Tests by the line that they run.

    Parameters
    ----------
    by_line : mapping
        For each file, relative to the package, and each line: the tests that run it.
    seconds : mapping of str to float
        How long each test took.
    importers : mapping
        For each file: the files that import it.
    """

    by_line: Mapping[str, Mapping[int, frozenset[str]]]
    seconds: Mapping[str, float]
    importers: Mapping[str, Sequence[str]] = field(default_factory=dict)

    @classmethod
    def read(cls, data_file: Path, duration_file: Path) -> CoveringTests:
        """What coverage and the plugin of durations wrote."""
        data = CoverageData(str(data_file))
        data.read()
        by_line = {
            _in_package(path): {
                line: frozenset(context.partition("|")[0] for context in contexts) - {""}
                for line, contexts in data.contexts_by_lineno(path).items()
            }
            for path in data.measured_files()
        }
        importers: dict[str, list[str]] = {}
        for path in sorted((ROOT / PACKAGE).rglob("*.py")):
            for imported in _imported_files(path.read_text("utf-8")):
                importers.setdefault(imported, []).append(_in_package(str(path)))
        return cls(by_line, json.loads(duration_file.read_text("utf-8")), importers)

    def of(self, file: str, lines: Iterable[int]) -> list[str]:
        """The tests that run one of the lines, those of the same subpackage and the fastest first.

        What runs at import belongs to no test, and is given all tests of the file, or, where the
        file has values only, of those that import it.
        """
        of_file = self.by_line.get(file, {})
        tests = frozenset().union(*(of_file.get(line, frozenset()) for line in lines))
        if not tests and any(line in of_file for line in lines):
            tests = frozenset().union(*of_file.values()) or frozenset().union(
                *(s for f in self.importers.get(file, ()) for s in self.by_line.get(f, {}).values())
            )
            tests |= frozenset(_OF_EVERY_FILE)
        beside = f"tests/unit/{Path(file).parent.as_posix()}/"
        known = (test for test in tests if test in self.seconds)
        return sorted(
            known, key=lambda test: (not test.startswith(beside), self.seconds[test], test)
        )

    def first(self, tests: Sequence[str], seconds: float) -> list[str]:
        """The first tests that together take so long, one at least."""
        ends = accumulate(self.seconds[test] for test in tests)
        kept = sum(end <= seconds for end in ends)
        return list(tests[: max(kept, 1)])

    def duration(self, tests: Iterable[str]) -> float:
        """How many seconds tests take together."""
        return sum(self.seconds[test] for test in tests)


def _imported_files(text: str) -> Iterator[str]:
    """The files of the package that a file takes names from, relative to the package."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module and "." in node.module:
            package, _, module = node.module.partition(".")
            if package == PACKAGE.name:
                yield f"{module.replace('.', '/')}.py"


def _in_package(path: str) -> str:
    return Path(path).as_posix().partition(f"{PACKAGE.as_posix()}/")[2]
