"""Equations in Julia, for DifferentialEquations.jl."""

from __future__ import annotations

from remanent.codegen.languages import lines
from remanent.codegen.languages.computation import Computation
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import WrittenEquations

_LANGUAGE = LANGUAGES["julia"]


def julia_files(equations: WrittenEquations) -> dict[str, str]:
    """``system.jl`` with ``rates!(dydt, y, p, t)`` and the loads, and ``run.jl``."""
    names = lines.own_identifiers(equations, _LANGUAGE)
    identifiers = lines.with_piece_entries(names, equations, "row[{}]", first=1)
    start = lines.number_list((variable.initial for variable in equations.state), _LANGUAGE)
    state = ", ".join(f'"{variable.name}"' for variable in equations.state)
    outputs = lines.output_texts(equations.rates, _LANGUAGE, identifiers)
    text = [
        *lines.header_lines(equations, _LANGUAGE, names),
        "",
        *_parameters(equations, names),
        f"const state_names = [{state}]",
        f"const initial = [{start}]",
        f"const breaks = Float64[{lines.number_list(equations.breaks, _LANGUAGE)}]",
        *_pieces(equations),
        "",
        *lines.needed_helpers(equations, _LANGUAGE),
        "",
        "function rates!(dydt, y, p, t)",
        *_body(equations, equations.rates, identifiers),
        *(f"    dydt[{k}] = {output}" for k, output in enumerate(outputs, 1)),
        "    return nothing",
        "end",
    ]
    for name, function in lines.load_function_names(equations).items():
        load = equations.loads[name]
        (output,) = lines.output_texts(load, _LANGUAGE, identifiers)
        body = [*_body(equations, load, identifiers), f"    return {output}"]
        text += ["", f"function {function}(t, p=parameters)", *body, "end"]
    return {"system.jl": lines.file_text(text), "run.jl": _run(equations)}


def _parameters(equations: WrittenEquations, names: dict[str, str]) -> list[str]:
    if not equations.parameters:
        return ["const parameters = NamedTuple()"]
    entries = (
        f"    {names[name]} = {_LANGUAGE.number(value)},"
        for name, value in equations.parameters.items()
    )
    return ["const parameters = (", *entries, ")"]


def _pieces(equations: WrittenEquations) -> list[str]:
    if not equations.pieces:
        return []
    rows = lines.number_rows(equations.pieces, _LANGUAGE, "    ({},),")
    return ["const pieces = [", *rows, "]", "const piece_starts = [row[1] for row in pieces]"]


def _body(
    equations: WrittenEquations, computation: Computation, identifiers: dict[str, str]
) -> list[str]:
    given = [
        f"{identifier} = p.{identifier}"
        for _, identifier in lines.needed_parameters(equations, computation, identifiers)
    ]
    given += [
        f"{identifier} = y[{k + 1}]"
        for k, identifier in lines.needed_state(equations, computation, identifiers)
    ]
    if equations.needs_pieces(computation):
        given.append("row = pieces[max(searchsortedlast(piece_starts, t), 1)]")
    return lines.indented([*given, *lines.assignment_lines(computation, _LANGUAGE, identifiers)], 4)


def _run(equations: WrittenEquations) -> str:
    duration = _LANGUAGE.number(equations.usual_duration)
    text = [
        *lines.comment_lines("Integrates the equations of motion in system.jl.", _LANGUAGE),
        "",
        "using DifferentialEquations",
        'include("system.jl")',
        "",
        f"problem = ODEProblem(rates!, initial, (0.0, {duration}), parameters)",
        "solution = solve(problem; abstol=1e-10, reltol=1e-10, d_discontinuities=breaks)",
        "println(solution.u[end])",
    ]
    return lines.file_text(text)
