"""Equations in Python, for SciPy."""

from __future__ import annotations

from remanent.codegen.languages import lines
from remanent.codegen.languages.computation import Computation
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import TIME, WrittenEquations

_LANGUAGE = LANGUAGES["python"]


def python_files(equations: WrittenEquations) -> dict[str, str]:
    """``system.py``: ``rates(t, y)``, the loads, ``initial``, ``parameters``."""
    names = lines.own_identifiers(equations, _LANGUAGE)
    identifiers = lines.with_piece_entries(names, equations, "row[{}]")
    state = ", ".join(f'"{variable.name}"' for variable in equations.state)
    start = lines.number_list((variable.initial for variable in equations.state), _LANGUAGE)
    text = [
        *lines.header_lines(equations, _LANGUAGE, names),
        "",
        *(["from bisect import bisect_right", ""] if equations.pieces else []),
        "import numpy as np",
        "",
        "parameters = {",
        *(f'    "{name}": {_LANGUAGE.number(x)},' for name, x in equations.parameters.items()),
        "}",
        f"state_names = ({state},)",
        f"initial = np.array([{start}])",
        f"breaks = [{lines.number_list(equations.breaks, _LANGUAGE)}]",
        *_pieces(equations),
        "",
        "",
        "def rates(t, y, parameters=parameters):",
        '    """Rates of the state variables at time t, for the state y."""',
        "    y = np.asarray(y, dtype=float)",
        *_body(equations, equations.rates, identifiers, "np.array([{}])"),
    ]
    for name, function in lines.load_function_names(equations).items():
        text += [
            "",
            "",
            f"def {function}(t, parameters=parameters):",
            f'    """Load at time t: {name}."""',
            *_body(equations, equations.loads[name], identifiers, "{}"),
        ]
    return {"system.py": lines.file_text(text)}


def _pieces(equations: WrittenEquations) -> list[str]:
    if not equations.pieces:
        return []
    rows = lines.number_rows(equations.pieces, _LANGUAGE, "    ({},),")
    return ["pieces = [", *rows, "]", "piece_starts = [row[0] for row in pieces]"]


def _body(
    equations: WrittenEquations, computation: Computation, identifiers: dict[str, str], result: str
) -> list[str]:
    # Numbers of NumPy become infinite or NaN where numbers of Python raise.
    given = [
        f'{identifier} = np.float64(parameters["{name}"])'
        for name, identifier in lines.needed_parameters(equations, computation, identifiers)
    ]
    given += [
        f"{identifier} = y[{k}]"
        for k, identifier in lines.needed_state(equations, computation, identifiers)
    ]
    if TIME in computation.input_names or equations.needs_pieces(computation):
        given.append("t = np.float64(t)")
    if equations.needs_pieces(computation):
        given.append("row = pieces[max(bisect_right(piece_starts, t) - 1, 0)]")
    outputs = ", ".join(lines.output_texts(computation, _LANGUAGE, identifiers))
    inner = [
        *lines.assignment_lines(computation, _LANGUAGE, identifiers),
        f"return {result.format(outputs)}",
    ]
    silenced = 'with np.errstate(all="ignore"):'
    return lines.indented([*given, silenced, *lines.indented(inner, 4)], 4)
