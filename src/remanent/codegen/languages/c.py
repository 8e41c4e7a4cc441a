"""Equations in C."""

from __future__ import annotations

from remanent.codegen.languages import lines
from remanent.codegen.languages.computation import Computation
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import WrittenEquations

_LANGUAGE = LANGUAGES["c"]
#: The piece that holds a time, by bisection.
_PIECE_AT = """
static const double *piece_at(double t)
{
    size_t low = 0, high = sizeof pieces/sizeof pieces[0] - 1;
    while (low < high) {
        const size_t middle = (low + high + 1)/2;
        if (pieces[middle][0] <= t)
            low = middle;
        else
            high = middle - 1;
    }
    return pieces[low];
}"""


def c_files(equations: WrittenEquations) -> dict[str, str]:
    """``system.c``: ``remanent_rates(t, y, dydt)``, the loads, what it starts from."""
    names = lines.own_identifiers(equations, _LANGUAGE)
    identifiers = lines.with_piece_entries(names, equations, "row[{}]")
    start = lines.number_list((variable.initial for variable in equations.state), _LANGUAGE)
    state = ", ".join(f'"{variable.name}"' for variable in equations.state)
    outputs = lines.output_texts(equations.rates, _LANGUAGE, identifiers)
    text = [
        *lines.header_lines(equations, _LANGUAGE, names),
        "",
        "#include <math.h>",
        "#include <stddef.h>",
        "",
        f"#define REMANENT_STATES {len(equations.state)}",
        "",
        f"const char *const remanent_state_names[REMANENT_STATES] = {{{state}}};",
        f"const double remanent_initial[REMANENT_STATES] = {{{start}}};",
        *_breaks(equations),
        *_parameters(equations, names),
        *_pieces(equations),
        "",
        "void remanent_rates(double t, const double *y, double *dydt)",
        "{",
        "    (void)t;",
        "    (void)y;",
        *_body(equations, equations.rates, identifiers),
        *(f"    dydt[{k}] = {output};" for k, output in enumerate(outputs)),
        "}",
    ]
    for name, function in lines.load_function_names(equations, "remanent_").items():
        load = equations.loads[name]
        (output,) = lines.output_texts(load, _LANGUAGE, identifiers)
        body = ["    (void)t;", *_body(equations, load, identifiers), f"    return {output};"]
        text += ["", f"double {function}(double t)", "{", *body, "}"]
    return {"system.c": lines.file_text(text)}


def _breaks(equations: WrittenEquations) -> list[str]:
    if not equations.breaks:
        return []
    numbers = lines.number_list(equations.breaks, _LANGUAGE)
    return [f"const double remanent_breaks[{len(equations.breaks)}] = {{{numbers}}};"]


def _parameters(equations: WrittenEquations, names: dict[str, str]) -> list[str]:
    if not equations.parameters:
        return []
    return [
        "",
        "struct remanent_parameters {",
        *(f"    double {names[name]};" for name in equations.parameters),
        "} remanent_parameters = {",
        *(
            f"    .{names[name]} = {_LANGUAGE.number(value)},"
            for name, value in equations.parameters.items()
        ),
        "};",
    ]


def _pieces(equations: WrittenEquations) -> list[str]:
    if not equations.pieces:
        return []
    size = f"[{len(equations.pieces)}][{len(equations.piece_columns)}]"
    rows = lines.number_rows(equations.pieces, _LANGUAGE, "    {{{}}},")
    return ["", f"static const double pieces{size} = {{", *rows, "};", *_PIECE_AT.split("\n")]


def _body(
    equations: WrittenEquations, computation: Computation, identifiers: dict[str, str]
) -> list[str]:
    given = [
        _LANGUAGE.assignment.format(identifier, f"remanent_parameters.{identifier}")
        for _, identifier in lines.needed_parameters(equations, computation, identifiers)
    ]
    given += [
        _LANGUAGE.assignment.format(identifier, f"y[{k}]")
        for k, identifier in lines.needed_state(equations, computation, identifiers)
    ]
    if equations.needs_pieces(computation):
        given.append("const double *row = piece_at(t);")
    return lines.indented([*given, *lines.assignment_lines(computation, _LANGUAGE, identifiers)], 4)
