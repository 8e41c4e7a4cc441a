"""Mutants of the numeric core: one small change of one place in the code.

The changes are those of Cosmic Ray.  A *site* is a piece of code that at least one of them
changes.  A sample draws sites, each as likely as any other, and at each site one of the
changes, so that code counts by what it computes, not by how many changes a sign has.

Left out, because no test could tell them or every test would:

* what is no code when the program runs: annotations;
* decorators that only save time or speak to type checkers;
* ``strict=True`` of ``zip``, which asserts what holds;
* signs of bits in place of signs of numbers and the reverse, which fail on every number;
* identity in place of equality and the reverse, which are the same for enumerations;
* the star between arguments by place and by name;
* what does not compile.
"""

from __future__ import annotations

import ast
import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, Final

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.provider import OperatorProvider

from tests.adequacy.core import PACKAGE, core_files

#: Changes that need a choice of names, and are not used.
_UNUSED: Final = ("VariableReplacer", "VariableInserter")
#: The nodes that changes with many variants can change; others are asked about every node.
_NODES_OF: Final = {
    "ReplaceBinaryOperator": ("operator",),
    "ReplaceComparisonOperator": ("comparison",),
    "ReplaceUnaryOperator": ("factor", "not_test"),
}
_BIT_SIGNS: Final = ("RShift", "LShift", "BitOr", "BitAnd", "BitXor")
_IDENTITY_SIGNS: Final = ("Is", "IsNot")
#: Decorators without which a function returns the same.
_WITHOUT_EFFECT: Final = (
    "cache",
    "lru_cache",
    "override",
    "final",
    "overload",
    "runtime_checkable",
)


@dataclass(frozen=True)
class Mutant:
    """A change of a file.

    Parameters
    ----------
    file : str
        The file, relative to the package.
    operator : str
        The change, as Cosmic Ray names it.
    occurrence : int
        Which of the places of this change in the file.
    start, end : tuple of int
        Line, from 1, and column of what is changed.
    """

    file: str
    operator: str
    occurrence: int
    start: tuple[int, int]
    end: tuple[int, int]

    @property
    def name(self) -> str:
        """The mutant, in a line."""
        line, column = self.start
        return f"{self.file}:{line}:{column} {self.operator.removeprefix('core/')}"


def sample(root: Path, *, size: int, seed: int) -> list[Mutant]:
    """A random sample of the mutants of the numeric core, without a site twice."""
    sites = list(chain.from_iterable(sites_of(root, file) for file in core_files(root)))
    choice = random.Random(seed)
    choice.shuffle(sites)
    drawn: list[Mutant] = []
    for variants in sites:
        if len(drawn) == size:
            break
        mutant = choice.choice(variants)
        if is_mutant(root, mutant):
            drawn.append(mutant)
    return drawn


def sites_of(root: Path, file: str) -> list[list[Mutant]]:
    """The sites of a file, each with the changes there."""
    nodes = list(ast_nodes(get_ast((root / PACKAGE / file).read_text("utf-8"))))
    nodes_of = {
        kind: [node for node in nodes if node.type in types] for kind, types in _NODES_OF.items()
    }
    sites: dict[tuple[Any, Any], list[Mutant]] = {}
    for name, operator in _operators().items():
        asked = nodes_of.get(name.partition("_")[0], nodes)
        positions = chain.from_iterable(operator().mutation_positions(node) for node in asked)
        for occurrence, (start, end) in enumerate(positions):
            mutant = Mutant(file, name, occurrence, start, end)
            sites.setdefault((start, end), []).append(mutant)
    return [sites[place] for place in sorted(sites)]


def mutated(root: Path, mutant: Mutant) -> str:
    """The text of the file with the change."""
    text = (root / PACKAGE / mutant.file).read_text("utf-8")
    return str(mutate_code(text, _operators()[mutant.operator](), mutant.occurrence))


def is_mutant(root: Path, mutant: Mutant) -> bool:
    """Whether the change compiles, and changes what runs."""
    try:
        after = _what_runs(mutated(root, mutant))
    except (SyntaxError, AttributeError):  # of names with dots, Cosmic Ray makes the latter
        return False
    return after != _what_runs((root / PACKAGE / mutant.file).read_text("utf-8"))


def statement_lines(root: Path, mutant: Mutant) -> range:
    """The lines of the smallest statement that holds the place, without its body."""
    tree = ast.parse((root / PACKAGE / mutant.file).read_text("utf-8"))
    line = mutant.start[0]
    spans = (_head(node) for node in ast.walk(tree) if isinstance(node, ast.stmt))
    return min((span for span in spans if line in span), key=len, default=range(line, line + 1))


def _head(statement: ast.stmt) -> range:
    """Lines of a statement up to its body."""
    decorators = getattr(statement, "decorator_list", [])
    first = min([statement.lineno, *(part.lineno for part in decorators)])
    body: Sequence[ast.stmt] = getattr(statement, "body", [])
    last = body[0].lineno - 1 if body else statement.end_lineno or statement.lineno
    return range(first, max(first, last) + 1)


@cache
def _operators() -> dict[str, Any]:
    provider = OperatorProvider()
    return {name: provider[name] for name in provider if _is_used(name)}


def _is_used(name: str) -> bool:
    if name in _UNUSED:
        return False
    kind, _, signs = name.partition("Operator_")
    if not signs:
        return True
    before, after = signs.split("_")
    apart = _BIT_SIGNS if kind.startswith("ReplaceBinary") else _IDENTITY_SIGNS
    return (before in apart) == (after in apart)


def _what_runs(text: str) -> str:
    return ast.dump(_WhatRuns().visit(ast.parse(text)))


class _WhatRuns(ast.NodeTransformer):
    """Leaves out of a tree what has no effect on results."""

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        node.args = [*node.posonlyargs, *node.args, *node.kwonlyargs]
        node.defaults = [*node.defaults, *filter(None, node.kw_defaults)]
        node.posonlyargs, node.kwonlyargs, node.kw_defaults = [], [], []
        return self.generic_visit(node)

    def visit_arg(self, node: ast.arg) -> ast.AST:
        node.annotation = None
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Name) and node.func.id == "zip":
            node.keywords = []
        return self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns = None
        node.decorator_list = [part for part in node.decorator_list if _has_effect(part)]
        return self.generic_visit(node)


def _has_effect(decorator: ast.expr) -> bool:
    called = decorator.func if isinstance(decorator, ast.Call) else decorator
    name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
    return name not in _WITHOUT_EFFECT
