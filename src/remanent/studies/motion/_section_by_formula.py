"""Sections in the space of states, where a formula vanishes."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import xarray as xr

from remanent._checks import is_integer, shortened_repr
from remanent._errors import InputError
from remanent.codegen.formula_program import formula_names, program_of_formula
from remanent.integrate import events
from remanent.models.formula import Formula, parse_formula
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_exactly_one_argument, trajectory_durations
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.motion._passages import passages_dataset

#: Name under which the formula stands among the observables.
_SECTION_NAME: Final = "section"
#: Directions of passages for each value of the argument; touches are none.
_SIGNS_OF_DIRECTION: Final = {1: (1,), -1: (-1,), 0: (1, -1)}


def section_by_formula(
    ens: Ensemble,
    where: str,
    direction: int,
    *,
    duration: float | None,
    periods: int | None,
    tolerance: float,
    progress: ProgressArgument,
) -> xr.Dataset:
    """States at each passage of a section; see :func:`remanent.poincare_section`."""
    require_exactly_one_argument(duration=duration, periods=periods)
    duration = without_unit("duration", duration, "time", ens.system)
    tolerance = require_tolerance(tolerance, "the global error of the state")
    signs = require_direction(direction)
    formula = _require_section(where, ens)
    problem = initial_value_problem(ens, trajectory_durations(ens, duration, periods))
    program = program_of_formula(problem.field, formula)
    field = replace(
        problem.field, observables={**problem.field.observables, _SECTION_NAME: program}
    )
    passages, outcome = events.find_crossings(
        replace(problem, field=field), _SECTION_NAME, 0.0, tolerance=tolerance,
        progress=as_progress(progress),
    )  # fmt: skip
    return passages_dataset(
        ens,
        passages.subset(np.isin(passages.direction, signs)),
        outcome,
        tolerance=tolerance,
        where=formula.text,
        direction=direction,
        duration=duration,
        periods=periods,
    )


def require_direction(direction: object) -> tuple[int, ...]:
    """The directions of passages that are taken."""
    if not is_integer(direction) or direction not in _SIGNS_OF_DIRECTION:
        raise InputError(
            "direction",
            must="be 1, -1 or 0",
            got=shortened_repr(direction),
            why="Passages are taken where the formula grows, where it falls, or both.",
            fix="Pass 1, -1 or 0.",
        )
    return _SIGNS_OF_DIRECTION[int(direction)]


def _require_section(where: object, ens: Ensemble) -> Formula:
    """The formula, if it has known names and a state among them."""
    field = ens.vector_field
    names = formula_names(field)
    if not isinstance(where, str):
        raise InputError(
            "where",
            must="be a formula",
            got=shortened_repr(where),
            why="The section is where it vanishes.",
            fix=f"Pass for example '{field.state_names[0]} - 1'.",
        )
    formula = parse_formula(where, "where")
    unknown = sorted(formula.variable_names - {*names})
    moving = {*field.state_names, *field.observable_and_rate_names}
    if unknown or not formula.variable_names & moving:
        raise InputError(
            "where",
            must=f"hold a state variable, and {', '.join(names)} only",
            got=shortened_repr(where),
            why="The section lies in the space of states.",
            fix=f"Pass for example '{field.state_names[0]} - 1'.",
        )
    return formula
