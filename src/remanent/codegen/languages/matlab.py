"""Equations in MATLAB and Octave: functions, and a script that integrates them."""

from __future__ import annotations

from remanent.codegen.languages import lines
from remanent.codegen.languages.computation import Computation
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import WrittenEquations

_LANGUAGE = LANGUAGES["matlab"]


def matlab_files(equations: WrittenEquations) -> dict[str, str]:
    """``remanent_rates.m`` and other functions, and the script ``remanent_run.m``."""
    names = lines.own_identifiers(equations, _LANGUAGE)
    identifiers = lines.with_piece_entries(names, equations, "row({})", first=1)
    header = lines.header_lines(equations, _LANGUAGE, names)
    outputs = lines.output_texts(equations.rates, _LANGUAGE, identifiers)
    count = len(equations.state)
    rates = [
        "function dydt = remanent_rates(t, y, p)",
        *header,
        "  if nargin < 3, p = remanent_parameters(); end",
        *_body(equations, equations.rates, identifiers),
        f"  dydt = zeros({count}, 1);",
        *(f"  dydt({k}) = {output};" for k, output in enumerate(outputs, 1)),
        "end",
    ]
    files = {
        "remanent_rates.m": _with_helpers(rates, equations),
        "remanent_parameters.m": _parameters(equations, names),
        "remanent_run.m": _script(equations, header),
    }
    for name, function in lines.load_function_names(equations, "remanent_").items():
        load = equations.loads[name]
        (output,) = lines.output_texts(load, _LANGUAGE, identifiers)
        text = [
            f"function z = {function}(t, p)",
            *lines.comment_lines(f"Load at time t: {name}.", _LANGUAGE),
            "  if nargin < 2, p = remanent_parameters(); end",
            *_body(equations, load, identifiers),
            f"  z = {output};",
            "end",
        ]
        files[f"{function}.m"] = _with_helpers(text, equations)
    if equations.pieces:
        files["remanent_pieces.m"] = _pieces(equations)
    return files


def _with_helpers(text: list[str], equations: WrittenEquations) -> str:
    helpers = [line for one in lines.needed_helpers(equations, _LANGUAGE) for line in ("", one)]
    return lines.file_text([*text, *helpers])


def _parameters(equations: WrittenEquations, names: dict[str, str]) -> str:
    text = [
        "function p = remanent_parameters()",
        *lines.comment_lines("The parameters by name.", _LANGUAGE),
        "  p = struct();",
        *(
            f"  p.{names[name]} = {_LANGUAGE.number(value)};"
            for name, value in equations.parameters.items()
        ),
        "end",
    ]
    return lines.file_text(text)


def _pieces(equations: WrittenEquations) -> str:
    rows = lines.number_rows(equations.pieces, _LANGUAGE, "      {};")
    text = [
        "function row = remanent_pieces(t)",
        *lines.comment_lines("The row of the piece of the load that holds the time t.", _LANGUAGE),
        "  persistent pieces",
        "  if isempty(pieces)",
        "    pieces = [",
        *rows,
        "    ];",
        "  end",
        "  row = pieces(max(sum(pieces(:, 1) <= t), 1), :);",
        "end",
    ]
    return lines.file_text(text)


def _body(
    equations: WrittenEquations, computation: Computation, identifiers: dict[str, str]
) -> list[str]:
    given = [
        _LANGUAGE.assignment.format(identifier, f"p.{identifier}")
        for _, identifier in lines.needed_parameters(equations, computation, identifiers)
    ]
    given += [
        _LANGUAGE.assignment.format(identifier, f"y({k + 1})")
        for k, identifier in lines.needed_state(equations, computation, identifiers)
    ]
    if equations.needs_pieces(computation):
        given.append("row = remanent_pieces(t);")
    return lines.indented([*given, *lines.assignment_lines(computation, _LANGUAGE, identifiers)], 2)


def _script(equations: WrittenEquations, header: list[str]) -> str:
    start = lines.number_list(
        (variable.initial for variable in equations.state), _LANGUAGE, "; ", " ..."
    )
    breaks = [one for one in equations.breaks if 0.0 < one < equations.usual_duration]
    ends = lines.number_list([0.0, *breaks, equations.usual_duration], _LANGUAGE, ", ", " ...")
    text = [
        *header,
        *lines.comment_lines("", _LANGUAGE),
        *lines.comment_lines(
            "This script integrates them, anew after each jump of the load, and draws the first "
            "state variable.",
            _LANGUAGE,
        ),
        "",
        "p = remanent_parameters();",
        f"y = [{start}].';",
        "t = 0;",
        f"ends = [{ends}];",
        "options = odeset('RelTol', 1e-9, 'AbsTol', 1e-12);",
        "for k = 1:numel(ends) - 1",
        "  % The load after a jump must not be met before it.",
        "  span = [ends(k), ends(k + 1)*(1 - eps)];",
        "  [tk, yk] = ode45(@(t, y) remanent_rates(t, y, p), span, y(end, :).', options);",
        "  t = [t; tk(2:end)];",
        "  y = [y; yk(2:end, :)];",
        "end",
        "try",
        "  plot(t, y(:, 1));",
        "  xlabel('t');",
        f"  ylabel('{equations.state[0].name}', 'Interpreter', 'none');",
        "catch failure",
        "  % Without a screen the motion is in t and y all the same.",
        "  disp(failure.message);",
        "end",
    ]
    return lines.file_text(text)
