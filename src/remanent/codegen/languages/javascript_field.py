"""A vector field in JavaScript as a page integrates it: in stages, without objects in between."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Final

from remanent._field import Field, Program
from remanent.codegen.formula_program import joined_program
from remanent.codegen.languages import lines
from remanent.codegen.languages.computation import computation_of
from remanent.codegen.languages.expressions import Expression, expression_text
from remanent.codegen.languages.javascript_pieces import PIECE_AT
from remanent.codegen.languages.stages import StagedProgram, staged_program
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import (
    PHASE,
    period_expression,
    table_of_pieces,
    waveform_expressions,
)
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.drives.sines import Sines

_LANGUAGE = LANGUAGES["javascript"]
#: Digits of the digest by which a module is called.
_ID_LENGTH: Final = 24
#: Functions that are the same in every module: what is asked for at a time, one state at once.
_COMMON: Final = """
const q = new Float64Array(constant_count);
const w = new Float64Array(driven_count);

function prepare(t, p) {
  constants(p, q);
  const length = period(p);
  if (length > 0) {
    const turns = t / length;
    driven(turns - Math.floor(turns), 0, q, w, 0);
  } else if (pieces.length > 0) {
    const piece = pieceAt(t);
    driven((t - pieces[piece][0]) / pieces[piece][1], piece, q, w, 0);
  } else {
    driven(t, 0, q, w, 0);
  }
}

/** The rates of the state, written into out. */
export function rates(t, y, p, out) {
  prepare(t, p);
  motion(y, 0, q, w, 0, out, 0);
  return out;
}

/** What is observed of the state, in the order of observable_names, written into out. */
export function observables(t, y, p, out) {
  prepare(t, p);
  observed(y, 0, q, w, 0, out, 0);
  return out;
}

/** Whether a state lies within the limits of the model. */
export function admissible(y, p) {
  constants(p, q);
  return inside(y, 0, q);
}"""


@dataclass(frozen=True)
class JavaScriptField:
    """A module with a vector field, and what has to be known of it.

    Attributes
    ----------
    source
        Its text.
    id
        By which it is called: a digest of the text.
    observable_names
        What it observes, in order.
    changeable
        Names of the parameters that it takes as they are given; others are in its text.
    """

    source: str
    id: str
    observable_names: tuple[str, ...]
    changeable: frozenset[str]


def javascript_field(
    field: Field, drive: Drive, values: Mapping[str, float], limits: Program | None
) -> JavaScriptField:
    """A vector field under a drive as a module.

    Parameters
    ----------
    field : Field
        The vector field under this drive.
    drive : Drive
        The law of its loads in time.
    values : mapping of str to float
        Values of all numeric fields.
    limits : Program or None
        What must be positive where the energies exist; of the inputs of the field.

    Returns
    -------
    JavaScriptField
        Its functions take typed arrays with an offset into each, so that nothing is made anew
        from step to step: ``constants(p, q)`` fills q from the parameters, ``driven(phase,
        piece, q, w, k)`` fills w from k on with all that time alone decides, and ``motion(y, i,
        q, w, k, out, j)`` and ``observed(...)`` read the state from i on and write from j on.
    """
    observables = _observables_in_order(field)
    given = _numbers_of_the_piece(drive)
    seen = [field.observables[name] for name in observables]
    staged = _staged(field, drive, seen, limits, given)
    rows, columns = table_of_pieces(drive)
    period = None if drive.period is None else period_expression(drive)
    names = _Identifiers(staged, columns, field.state_names, given)
    text = [
        *_exported_constants(field, drive, values, observables, rows, staged),
        *_function("period(p)", [f"return {names.period_text(period)};"]),
        *_function("constants(p, q)", _constants_body(staged, names)),
        *_function("driven(phase, piece, q, w, k)", _driven_body(staged, drive, names)),
        *_function("motion(y, i, q, w, k, out, j)", _moving_body(staged, "motion", names)),
        *_function("observed(y, i, q, w, k, out, j)", _moving_body(staged, "observed", names)),
        *_function("inside(y, i, q)", _inside_body(staged, field, names)),
        "",
        *PIECE_AT.split("\n"),
        *_COMMON.split("\n"),
    ]
    body = lines.file_text(text)
    digest = hashlib.sha256(body.encode()).hexdigest()[:_ID_LENGTH]
    changeable = {given.get(name, name) for name in staged.constants.input_names} & {*values}
    if isinstance(period, tuple):
        changeable.add(str(period[2]))
    source = f'export const id = "{digest}";\n{body}'
    return JavaScriptField(source, digest, observables, frozenset(changeable))


def _observables_in_order(field: Field) -> tuple[str, ...]:
    """What is observed: the quantity that is followed, its rate, energies, loads, the others."""
    first = (*field.observable_and_rate_names, "energy", "stored_energy", *field.load_names)
    known = [name for name in first if name in field.observables]
    return tuple(dict.fromkeys([*known, *sorted(field.observables)]))


def _numbers_of_the_piece(drive: Drive) -> dict[str, str]:
    """Parameters of the one piece of a load that are numbers of the drive themselves.

    Sines without a period have one piece of length 1, at whose end the angle is omega.
    """
    parts = drive.parts().items() if isinstance(drive, Loads) else [("", drive)]
    prefixes = [
        f"{load}." if load else ""
        for load, one in parts
        if isinstance(one, Sines) and one.piece_parameter_names
    ]
    return {f"{prefix}piece.turns": f"{prefix}omega" for prefix in prefixes}


def _staged(
    field: Field,
    drive: Drive,
    observables: Sequence[Program],
    limits: Program | None,
    given: Mapping[str, str],
) -> StagedProgram:
    programs = {"motion": [field.rates], "observed": [*observables]}
    programs["inside"] = [] if limits is None else [limits]
    joined = joined_program([one for several in programs.values() for one in several])
    first = 0
    outputs: dict[str, range] = {}
    for name, several in programs.items():
        count = sum(len(one.output_slots) for one in several)
        outputs[name] = range(first, first + count)
        first += count
    driven = {PHASE, *field.waveform_names, *drive.piece_parameter_names} - {*given}
    constant = {*field.parameter_names} - driven
    return staged_program(joined, outputs, constant, driven)


class _Identifiers:
    """The text of each name in a module."""

    def __init__(
        self,
        staged: StagedProgram,
        columns: Sequence[str],
        state_names: Sequence[str],
        given: Mapping[str, str],
    ) -> None:
        self.constants = {name: f"q[{k}]" for k, name in enumerate(staged.constant_names)}
        self.driven = {name: f"w[k + {k}]" for k, name in enumerate(staged.driven_names)}
        self.state = {name: f"y[i + {k}]" for k, name in enumerate(state_names)}
        self.row = {name: f"row[{k}]" for k, name in enumerate(columns)}
        self.parameters = {
            name: f"p[{json.dumps(given.get(name, name))}]" for name in staged.constants.input_names
        }
        self.texts = {**self.constants, **self.driven, **self.state, **self.row, PHASE: "phase"}

    def period_text(self, period: Expression | None) -> str:
        """The period in terms of the parameters; not a number where there is none."""
        if period is None:
            return _LANGUAGE.not_a_number
        name = {str(period[2]): f"p[{json.dumps(period[2])}]"} if isinstance(period, tuple) else {}
        return expression_text(period, _LANGUAGE, name)


def _function(head: str, body: Iterable[str]) -> list[str]:
    return ["", f"export function {head} {{", *lines.indented(body, 2), "}"]


def _exported_constants(
    field: Field,
    drive: Drive,
    values: Mapping[str, float],
    observables: Sequence[str],
    rows: Sequence[Sequence[float]],
    staged: StagedProgram,
) -> list[str]:
    known_until = drive.known_until
    breaks = [row[0] for row in rows[1:]]
    return [
        "export const parameters = {",
        *(f"  {json.dumps(name)}: {_LANGUAGE.number(x)}," for name, x in values.items()),
        "};",
        f"export const state_names = {json.dumps([*field.state_names])};",
        f"export const observable_names = {json.dumps([*observables])};",
        f"export const breaks = [{lines.number_list(breaks, _LANGUAGE)}];",
        f"export const known_until = {_LANGUAGE.number(known_until)};",
        "export const pieces = [",
        *lines.number_rows(rows, _LANGUAGE, "  [{}],"),
        "];",
        f"export const constant_count = {len(staged.constant_names)};",
        f"export const driven_count = {len(staged.driven_names)};",
    ]


def _program_body(
    program: Program,
    texts: Mapping[str, str],
    targets: Sequence[str],
    before: Sequence[tuple[str, Expression]] = (),
) -> list[str]:
    """Statements that read the inputs of a program once, compute, and write its outputs."""
    computation = computation_of(program).after(before)
    names = [name for name in texts if name in computation.input_names]
    given = {name: f"x{k}" for k, name in enumerate(names)}
    assigned = {name: f"v{k}" for k, (name, _) in enumerate(computation.assignments)}
    local = {**given, **assigned}
    outputs = lines.output_texts(computation, _LANGUAGE, local)
    return [
        *(f"const {given[name]} = {texts[name]};" for name in names),
        *lines.assignment_lines(computation, _LANGUAGE, local),
        *(f"{target} = {output};" for target, output in zip(targets, outputs, strict=True)),
    ]


def _constants_body(staged: StagedProgram, names: _Identifiers) -> list[str]:
    return _program_body(staged.constants, names.parameters, [*names.constants.values()])


def _driven_body(staged: StagedProgram, drive: Drive, names: _Identifiers) -> list[str]:
    targets = [*names.driven.values()]
    body = _program_body(staged.driven, names.texts, targets, waveform_expressions(drive))
    reads_row = any("= row[" in line for line in body)
    return [*(["const row = pieces[piece];"] if reads_row else []), *body]


def _moving_body(staged: StagedProgram, name: str, names: _Identifiers) -> list[str]:
    program = staged.moving[name]
    targets = [f"out[j + {k}]" for k in range(len(program.output_slots))]
    return _program_body(program, names.texts, targets)


def _inside_body(staged: StagedProgram, field: Field, names: _Identifiers) -> list[str]:
    program = staged.moving["inside"]
    met = [f"c{k}" for k in range(len(program.output_slots))]
    body = _program_body(program, names.texts, [f"const {one}" for one in met])
    positive = [f"{names.state[one.name]} > 0" for one in field.variables if one.positive]
    conditions = [f"{one} > 0" for one in met]
    return [*body, f"return {' && '.join(chain(positive, conditions)) or 'true'};"]
