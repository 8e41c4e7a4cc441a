"""Lines that all languages have in common: the header, and assignments."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from textwrap import wrap
from typing import Final

from remanent.codegen.languages.computation import Computation
from remanent.codegen.languages.expressions import expression_text, operations_in
from remanent.codegen.languages.identifiers import identifiers_of
from remanent.codegen.languages.language import Language
from remanent.codegen.languages.written import TIME, WrittenEquations

#: Width of comments, in characters.
_COMMENT_WIDTH: Final = 92
#: Numbers in one line of a table.
_NUMBERS_A_LINE: Final = 6


def own_identifiers(equations: WrittenEquations, language: Language) -> dict[str, str]:
    """An identifier for every name of the equations, and for the time."""
    return {TIME: "t", **identifiers_of(equations.names, language)}


def with_piece_entries(
    identifiers: Mapping[str, str], equations: WrittenEquations, entry: str, first: int = 0
) -> dict[str, str]:
    """Identifiers, and the entry of the table of pieces that each of its columns is.

    Parameters
    ----------
    identifiers
        Of everything else.
    equations
        Which have the columns.
    entry
        The text of an entry, with a place for its number, such as ``row[{}]``.
    first
        The number of the first entry.
    """
    entries = {
        name: entry.format(k) for k, name in enumerate(equations.piece_columns, first)
    } if equations.pieces else {}  # fmt: skip
    # Where there is one piece, its numbers are assigned like any other.
    return {**entries, **identifiers}


def header_lines(
    equations: WrittenEquations,
    language: Language,
    identifiers: Mapping[str, str],
    further: Iterable[str] = (),
) -> list[str]:
    """Comments: what it is, what made it, units, the state, the parameters, the load.

    `further` lines come at the end.
    """
    text = [*equations.description, "", *_state_lines(equations, identifiers)]
    if equations.parameters:
        text += ["", "Parameters:"]
        text += [
            f"  {name} = {value!r}{_written_as(name, identifiers)}"
            for name, value in equations.parameters.items()
        ]
    if equations.unused:
        text += ["", "Numbers that the statements below do not need, or hold already:"]
        text += [f"  {name} = {value!r}" for name, value in equations.unused.items()]
    text += ["", *_load_lines(equations), *further]
    return [comment for line in text for comment in comment_lines(line, language)]


def _state_lines(equations: WrittenEquations, identifiers: Mapping[str, str]) -> Iterator[str]:
    yield "The state, in order, with units and where it starts:"
    for variable in equations.state:
        written = _written_as(variable.name, identifiers)
        yield f"  {variable.name} ({variable.unit}), {variable.initial!r}{written}"


def _written_as(name: str, identifiers: Mapping[str, str]) -> str:
    identifier = identifiers.get(name, name)
    return "" if identifier == name else f", written {identifier}"


def _load_lines(equations: WrittenEquations) -> Iterator[str]:
    if equations.period is not None:
        yield f"The load repeats after {equations.period!r}."
    if equations.pieces:
        yield (
            "The load is given piece by piece: in each row the time at which the piece starts, its "
            "length, and its own numbers. The last row holds from its start on."
        )
    if equations.breaks:
        yield (
            "The load jumps or bends at the times in `breaks`. At a jump its value is that after "
            "it: start an integrator anew there."
        )
    if math.isfinite(equations.known_until):
        yield (
            f"The load is known until {equations.known_until!r}; after that it, and the rates, are "
            "no numbers."
        )


def comment_lines(line: str, language: Language) -> list[str]:
    """A line of text as comments of some width; characters beyond ASCII become question marks."""
    plain = re.sub(r"[^ -\[\]-~]", "?", line)
    indent = " " * (len(plain) - len(plain.lstrip()))
    wrapped = wrap(plain, _COMMENT_WIDTH, subsequent_indent=f"{indent}  ") or [""]
    return [f"{language.comment} {one}".rstrip() for one in wrapped]


def assignment_lines(
    computation: Computation, language: Language, identifiers: Mapping[str, str]
) -> list[str]:
    """The assignments of a computation, one a line."""
    return [
        language.assignment.format(identifiers[name], expression_text(value, language, identifiers))
        for name, value in computation.assignments
    ]


def output_texts(
    computation: Computation, language: Language, identifiers: Mapping[str, str]
) -> list[str]:
    """The text of each result."""
    return [expression_text(value, language, identifiers) for value in computation.outputs]


def needed_state(
    equations: WrittenEquations, computation: Computation, identifiers: Mapping[str, str]
) -> list[tuple[int, str]]:
    """Number and identifier of each state variable that a computation reads."""
    names = enumerate(variable.name for variable in equations.state)
    return [(k, identifiers[name]) for k, name in names if name in computation.input_names]


def needed_parameters(
    equations: WrittenEquations, computation: Computation, identifiers: Mapping[str, str]
) -> list[tuple[str, str]]:
    """Name and identifier of each parameter that a computation reads."""
    names = (name for name in equations.parameters if name in computation.input_names)
    return [(name, identifiers[name]) for name in names]


def needed_helpers(equations: WrittenEquations, language: Language) -> list[str]:
    """Functions that stand in for operations that the equations have."""
    computations = (equations.rates, *equations.loads.values())
    used = {
        operation
        for one in computations
        for value in (*(value for _, value in one.assignments), *one.outputs)
        for operation in operations_in(value)
    }
    return [text for operation, text in language.helpers.items() if operation in used]


def load_function_names(equations: WrittenEquations, prefix: str = "") -> dict[str, str]:
    """The name of the function of each load."""
    return {
        name: f"{prefix}load" if name == "load" else f"{prefix}load_{name}"
        for name in equations.loads
    }


def number_rows(
    rows: Iterable[Iterable[float]], language: Language, row: str, separator: str = ", "
) -> list[str]:
    """Rows of numbers, each in the text `row` with a place for them."""
    return [row.format(separator.join(map(language.number, numbers))) for numbers in rows]


def number_list(
    numbers: Iterable[float], language: Language, separator: str = ", ", continuation: str = ""
) -> str:
    """Numbers in one text, with a new line after some, and what a language wants before it."""
    texts = list(map(language.number, numbers))
    lines = [texts[k : k + _NUMBERS_A_LINE] for k in range(0, len(texts), _NUMBERS_A_LINE)]
    return f"{separator.rstrip()}{continuation}\n  ".join(separator.join(line) for line in lines)


def indented(lines: Iterable[str], by: int) -> list[str]:
    """Lines moved to the right."""
    return [f"{' ' * by}{line}" if line else line for line in lines]


def file_text(lines: Iterable[str]) -> str:
    """The text of a file."""
    return "\n".join(lines) + "\n"
