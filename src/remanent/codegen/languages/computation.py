"""A program as assignments of a few lines each: what the functions of other languages hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from remanent._field import Program
from remanent.codegen.languages.expressions import Expression, leaf_count, names_in

#: Values that are used once are written where they are used, in expressions of up to so many names.
_LARGEST_EXPRESSION = 8


@dataclass(frozen=True)
class Computation:
    """Values that are computed one after the other, and what comes of them.

    Attributes
    ----------
    assignments
        Names, each with the expression of its value.
    outputs
        One expression for each result.
    """

    assignments: tuple[tuple[str, Expression], ...]
    outputs: tuple[Expression, ...]

    @property
    def input_names(self) -> frozenset[str]:
        """Names of the values that have to be given."""
        expressions = [*(value for _, value in self.assignments), *self.outputs]
        needed = {name for expression in expressions for name in names_in(expression)}
        return frozenset(needed - {name for name, _ in self.assignments})

    def after(self, earlier: Sequence[tuple[str, Expression]]) -> Computation:
        """The computation after further assignments, of which only those are kept that it needs."""
        needed, kept = set(self.input_names), []
        for name, value in reversed(earlier):
            if name in needed:
                kept.append((name, value))
                needed |= {*names_in(value)}
        return Computation((*reversed(kept), *self.assignments), self.outputs)


def computation_of(program: Program, prefix: str = "v.") -> Computation:
    """A program with values that are used once written where they are used.

    Parameters
    ----------
    program
        Straight-line code.
    prefix
        Of the names of values in between, which are numbered.
    """
    uses = Counter(slot for _, *operands in program.instructions for slot in operands)
    uses.update(program.output_slots)
    values: list[Expression] = [*program.input_names, *program.constants]
    assignments: list[tuple[str, Expression]] = []
    for operation, *operands in program.instructions:
        value: Expression = (operation, *(values[k] for k in operands))
        if uses[len(values)] != 1 or leaf_count(value) > _LARGEST_EXPRESSION:
            name = f"{prefix}{len(assignments) + 1}"
            assignments.append((name, value))
            value = name
        values.append(value)
    return Computation(tuple(assignments), tuple(values[k] for k in program.output_slots))
