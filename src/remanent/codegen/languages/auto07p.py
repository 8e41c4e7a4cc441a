"""Equations for AUTO-07p: equations file, constants, and the orbit to start from."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import count, islice
from typing import Final

from remanent._typing import FloatArray
from remanent.codegen.languages import lines
from remanent.codegen.languages.table import LANGUAGES
from remanent.codegen.languages.written import PHASE, WrittenEquations

_LANGUAGE = LANGUAGES["auto07p"]
#: Longest part of a statement in one line; Fortran takes 132 characters.
_LINE_LENGTH: Final = 100
#: Indices of parameters that AUTO keeps for itself: it writes the period of an orbit in the
#: second, and in the third, at every step, the angle of a torus.
_KEPT_INDICES: Final = frozenset({10, 11, 12})
#: What stands for rates that do not exist.  AUTO takes NaN for converged, and goes on with it; of
#: this it makes a smaller step.
_NO_RATE: Final = "1.0D30"
#: The end of the equations file: what this problem does not need.
_EMPTY_ROUTINES: Final = ("ICND", "FOPT")
#: Arguments of the routine of the rates.
_RATES_START: Final = """
      SUBROUTINE FUNC(NDIM,U,ICP,PAR,IJAC,F,DFDU,DFDP)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), IJAC
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(OUT) :: F(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: DFDU(NDIM,NDIM), DFDP(NDIM,*)"""
#: Arguments of the routine of the values to start from.
_START_START: Final = """
      SUBROUTINE STPNT(NDIM,U,PAR,T)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(INOUT) :: U(NDIM), PAR(*)
      DOUBLE PRECISION, INTENT(IN) :: T"""
#: Arguments of the routine of the boundary values.
_BOUNDARY_START: Final = """
      SUBROUTINE BCND(NDIM,PAR,ICP,NBC,U0,U1,FB,IJAC,DBC)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM, ICP(*), NBC, IJAC
      DOUBLE PRECISION, INTENT(IN) :: PAR(*), U0(NDIM), U1(NDIM)
      DOUBLE PRECISION, INTENT(OUT) :: FB(NBC)
      DOUBLE PRECISION, INTENT(INOUT) :: DBC(NBC,*)"""
#: The routine of what is shown of every solution.
_SHOWN: Final = """
      SUBROUTINE PVLS(NDIM,U,PAR)
      IMPLICIT NONE
      INTEGER, INTENT(IN) :: NDIM
      DOUBLE PRECISION, INTENT(IN) :: U(NDIM)
      DOUBLE PRECISION, INTENT(INOUT) :: PAR(*)
      DOUBLE PRECISION, EXTERNAL :: GETP
      PAR({}) = GETP("BV0",1,U)
      END SUBROUTINE PVLS"""


def auto07p_files(
    equations: WrittenEquations, phases: FloatArray, orbit: FloatArray, conservative: bool
) -> dict[str, str]:
    """``system.f90``, ``c.system`` and ``system.dat``.

    Parameters
    ----------
    equations : WrittenEquations
        Under a load with a period.
    phases : array (node,)
        Phases of the load from 0 to 1.
    orbit : array (node, state)
        A periodic orbit at these phases.
    conservative : bool
        Whether multipliers lie on the unit circle, where no bifurcation is told by their number.
    """
    indices = _parameter_indices(equations)
    shown = next(k for k in _allowed_indices() if k > max(indices.values(), default=0))
    constants = _constants(equations, indices, shown, conservative)
    rows = (
        " ".join(repr(float(x)) for x in (phase, *state, phase))
        for phase, state in zip(phases, orbit, strict=True)
    )
    return {
        "system.f90": _equations_file(equations, indices, shown),
        "c.system": lines.file_text(constants),
        "system.dat": lines.file_text(rows),
    }


def _allowed_indices() -> Iterator[int]:
    return (k for k in count(1) if k not in _KEPT_INDICES)


def _parameter_indices(equations: WrittenEquations) -> dict[str, int]:
    """Index of each parameter in PAR; the frequency comes first."""
    first = [equations.period_field] if equations.period_field in equations.parameters else []
    names = dict.fromkeys([*filter(None, first), *equations.parameters])
    return dict(zip(names, islice(_allowed_indices(), len(names)), strict=True))


def _equations_file(equations: WrittenEquations, indices: dict[str, int], shown: int) -> str:
    rates = equations.rates_over_period
    assert rates is not None
    phase = len(equations.state) + 1
    names = {**lines.own_identifiers(equations, _LANGUAGE), PHASE: f"U({phase})"}
    assigned = [
        *(f"{names[name]} = PAR({k})" for name, k in indices.items() if name in rates.input_names),
        *(f"{name} = U({k + 1})" for k, name in lines.needed_state(equations, rates, names)),
    ]
    declared = [text.partition(" = ")[0] for text in assigned]
    declared += [names[name] for name, _ in rates.assignments]
    outputs = lines.output_texts(rates, _LANGUAGE, names)
    statements = [
        *(f"DOUBLE PRECISION {name}" for name in declared),
        *assigned,
        *lines.assignment_lines(rates, _LANGUAGE, names),
        *(f"F({k}) = {output}" for k, output in enumerate(outputs, 1)),
        f"WHERE (.NOT. ABS(F(1:{phase - 1})) < {_NO_RATE}) F(1:{phase - 1}) = {_NO_RATE}",
        f"F({phase}) = 1",
    ]
    start = [f"PAR({k}) = {_LANGUAGE.number(equations.parameters[n])}" for n, k in indices.items()]
    ends = [
        *(f"FB({k}) = U0({k}) - U1({k})" for k in range(1, phase)),
        f"FB({phase}) = U0({phase})",
    ]
    routines = [
        *_routine(_RATES_START, statements, "FUNC"),
        *_routine(_START_START, start, "STPNT"),
        *_routine(_BOUNDARY_START, ends, "BCND"),
        *(
            line
            for name in _EMPTY_ROUTINES
            for line in _routine(f"\n      SUBROUTINE {name}", [], name)
        ),
        *_SHOWN.format(shown).split("\n"),
    ]
    header = lines.header_lines(
        equations, _LANGUAGE, names, _how_it_is_posed(equations, indices, shown)
    )
    return lines.file_text([*header, *routines])


def _routine(start: str, statements: list[str], name: str) -> list[str]:
    continued = [line for one in statements for line in _continued(one)]
    return [*start.split("\n"), *lines.indented(continued, 6), f"      END SUBROUTINE {name}"]


def _continued(statement: str) -> list[str]:
    """A statement in lines that Fortran takes, broken before or after a name or a number."""
    tokens = re.findall(r"[\w.]+(?:(?<=D)-\d+)?|\W", statement)
    parts = [""]
    for token in tokens:
        if len(parts[-1]) + len(token) > _LINE_LENGTH:
            parts.append("")
        parts[-1] += token
    return [*(f"{part}&" for part in parts[:-1]), parts[-1]]


def _how_it_is_posed(equations: WrittenEquations, indices: dict[str, int], shown: int) -> list[str]:
    phase = len(equations.state) + 1
    state = ", ".join(variable.name for variable in equations.state)
    return [
        "",
        f"U(1:{phase - 1}) = {state}; U({phase}) = phase s of the load; the interval [0, 1] is one "
        "period. Boundary conditions of periodic type with s(0) = 0 (IPS = 7), so that every "
        "solution starts at phase 0 of the load.",
        f"Where the rates are no numbers F is {_NO_RATE}, of which AUTO makes a smaller step.",
        *(f"PAR({k}) = {name}" for name, k in indices.items()),
        "PAR(1) varies, up to half and twice its value; others do where ICP in c.system says so.",
        f"PAR({shown}) = U(1) at phase 0, which is only shown.",
        "The orbit to start from is in system.dat, constants are in c.system.",
    ]


def _constants(
    equations: WrittenEquations, indices: dict[str, int], shown: int, conservative: bool
) -> list[str]:
    count = len(equations.state) + 1
    value = equations.parameters[next(iter(indices))]
    low, high = sorted((0.5 * value, 2.0 * value)) if value else (-1.0, 1.0)
    size = abs(value) or 1.0
    return [
        "dat = 'system'",
        f"NDIM=   {count}, IPS =   7, IRS =   0, ILP =   1",
        f"ICP =  [1, {shown}]",
        f"NTST= 100, NCOL=   7, IAD =   3, ISP =   2, ISW = 1, IPLT= 0, NBC= {count}, NINT= 0",
        "NMX= 2000, NPR=   20, MXBF=   0, IID =   2, ITMX= 30, ITNW= 8, NWTN= 4, JAC= 0",
        "EPSL= 1e-9, EPSU = 1e-9, EPSS = 1e-7",
        # With larger steps AUTO takes the sharp turn of a branch at a narrow peak for a fold.
        f"DS  = {0.005 * size!r}, DSMIN= {1e-7 * size!r}, DSMAX= {0.01 * size!r}, IADS=   1",
        f"NPAR = {shown}, THL =  {{}}, THU =  {{{count}: 0.0}}",
        # Of undamped motion AUTO's tests for these two mean nothing.
        *(["SP = ['TR0', 'PD0']"] if conservative else []),
        f"UZSTOP = {{1: [{low!r}, {high!r}]}}",
    ]
