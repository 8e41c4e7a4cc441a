"""Equations in JavaScript, as a module."""

from __future__ import annotations

from remanent.codegen.languages import lines
from remanent.codegen.languages.computation import Computation
from remanent.codegen.languages.javascript_pieces import PIECE_AT
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import WrittenEquations

_LANGUAGE = LANGUAGES["javascript"]


def javascript_files(equations: WrittenEquations) -> dict[str, str]:
    """``system.js``: ``rates(t, y)``, the loads, ``initial``, ``parameters``."""
    names = lines.own_identifiers(equations, _LANGUAGE)
    identifiers = lines.with_piece_entries(names, equations, "row[{}]")
    start = lines.number_list((variable.initial for variable in equations.state), _LANGUAGE)
    state = ", ".join(f'"{variable.name}"' for variable in equations.state)
    outputs = ", ".join(lines.output_texts(equations.rates, _LANGUAGE, identifiers))
    text = [
        *lines.header_lines(equations, _LANGUAGE, names),
        "",
        "export const parameters = {",
        *(f'  "{name}": {_LANGUAGE.number(x)},' for name, x in equations.parameters.items()),
        "};",
        f"export const state_names = [{state}];",
        f"export const initial = [{start}];",
        f"export const breaks = [{lines.number_list(equations.breaks, _LANGUAGE)}];",
        *_pieces(equations),
        "",
        "export function rates(t, y, p = parameters) {",
        *_body(equations, equations.rates, identifiers),
        f"  return [{outputs}];",
        "}",
    ]
    for name, function in lines.load_function_names(equations).items():
        load = equations.loads[name]
        (output,) = lines.output_texts(load, _LANGUAGE, identifiers)
        body = [*_body(equations, load, identifiers), f"  return {output};"]
        text += ["", f"export function {function}(t, p = parameters) {{", *body, "}"]
    return {"system.js": lines.file_text(text)}


def _pieces(equations: WrittenEquations) -> list[str]:
    if not equations.pieces:
        return []
    rows = lines.number_rows(equations.pieces, _LANGUAGE, "  [{}],")
    return ["const pieces = [", *rows, "];", "", *PIECE_AT.split("\n")]


def _body(
    equations: WrittenEquations, computation: Computation, identifiers: dict[str, str]
) -> list[str]:
    given = [
        _LANGUAGE.assignment.format(identifier, f'p["{name}"]')
        for name, identifier in lines.needed_parameters(equations, computation, identifiers)
    ]
    given += [
        _LANGUAGE.assignment.format(identifier, f"y[{k}]")
        for k, identifier in lines.needed_state(equations, computation, identifiers)
    ]
    if equations.needs_pieces(computation):
        given.append("const row = pieces[pieceAt(t)];")
    return lines.indented([*given, *lines.assignment_lines(computation, _LANGUAGE, identifiers)], 2)
