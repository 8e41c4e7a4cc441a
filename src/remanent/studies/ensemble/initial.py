"""Where trajectories start, and which starts make no sense."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from remanent._checks import as_float_array, shortened_repr
from remanent._errors import InputError
from remanent._field import Field, Role, StateVariable
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.models.system import System

#: Largest stretch and rate, and inverse of the smallest stretch, to start from.
LARGEST_STARTING_STATE = 1e6


def initial_states(
    initial: ArrayLike | None,
    varied: Mapping[str, FloatArray],
    field: Field,
    values: Mapping[str, FloatArray],
    count: int,
) -> FloatArray:
    """Initial states: at rest, save for what was given for all or varied.

    Parameters
    ----------
    initial : array_like (state,), optional
        Coordinates and rates of all trajectories, or the whole state.
    varied : mapping of name to array (trajectory,)
        What ``over`` varies; a state variable is called ``initial.<name>`` there.
    field : Field
        Whose state it is.
    values : mapping of name to array (trajectory,)
        Numeric fields, on which values at rest depend.
    count : int
        Number of trajectories.

    Returns
    -------
    array (trajectory, state)
        It may be read-only: all trajectories share one row where nothing differs.
    """
    rest = [default_initial_values(variable, values, count) for variable in field.variables]
    first = np.array([column[0] for column in rest])
    given = first[:0] if initial is None else _require_given_state(initial, field)
    columns = {
        k: varied[f"initial.{name}"]
        for k, name in enumerate(field.state_names)
        if f"initial.{name}" in varied
    }
    for k, column in enumerate(rest):
        # A column with a stride holds values that differ: a temperature that `over` varies.
        if k >= given.size and column.strides != (0,):
            columns.setdefault(k, column)
    _require_valid_common_start(given, [k for k in range(given.size) if k not in columns], field)
    row = np.append(given, first[given.size :])
    states = np.broadcast_to(row, (count, len(rest)))
    if columns:
        states = states.copy()
        for k, column in columns.items():
            states[:, k] = column
    return states


def _require_given_state(initial: ArrayLike, field: Field) -> FloatArray:
    """The state to start from, array (given,): coordinates and rates, or all of it."""
    moving = field.names_of_roles(Role.COORDINATE, Role.RATE)
    entire = f", or all of {', '.join(field.state_names)}" if moving != [*field.state_names] else ""
    what = f"{', '.join(moving)}{entire}"
    why = "A motion starts from one state."
    first = field.state_names[0]
    fix = f"Leave it out to start from rest; vary it by over={{'initial.{first}': ...}}."
    state = as_float_array("initial", initial, what=what, why=why, fix=fix, ndim=1, finite=True)
    if state.size not in {len(moving), len(field.state_names)}:
        raise InputError(
            "initial",
            must=f"be {len(moving)} finite numbers, ({', '.join(moving)}){entire}",
            got=shortened_repr(initial),
            why=why,
            fix=fix,
        )
    return state


def _require_valid_common_start(given: FloatArray, fixed: list[int], field: Field) -> None:
    """Raise where what all trajectories start from is no state; what varies has a status."""
    for k in fixed:
        variable = field.variables[k]
        if variable.positive and not given[k] > 0.0:
            raise InputError(
                "initial",
                must=f"have a {variable.name} greater than 0",
                got=given[k],
                why="Stretches are ratios of lengths, temperatures are absolute.",
                fix="Pass 1 for the undeformed block.",
            )


def default_initial_values(
    variable: StateVariable, values: Mapping[str, FloatArray], count: int
) -> FloatArray:
    """Value of a state variable at rest, array (trajectory,)."""
    return np.broadcast_to(variable.value_at_rest(values), (count,))


def is_invalid_start(
    system: System, values: Mapping[str, FloatArray], states: FloatArray, field: Field
) -> BoolArray:
    """Where a state is no state to start from, array (trajectory,) of bool."""
    invalid = ~(np.abs(states) <= LARGEST_STARTING_STATE).all(axis=1)
    invalid |= ~(states[:, _positive_variable_indices(field)] >= 1.0 / LARGEST_STARTING_STATE).all(
        axis=1
    )
    return np.asarray(invalid | ~_is_admissible(system, values, states, field))


def require_admissible_state(
    system: System, values: Mapping[str, FloatArray], states: FloatArray, field: Field
) -> None:
    """Raise what is wrong with the first of the states, if anything is."""
    state = states[0]
    _require_valid_common_start(state, list(range(state.size)), field)
    inside = (state[_positive_variable_indices(field)] >= 1.0 / LARGEST_STARTING_STATE).all()
    if not (inside and (np.abs(state) <= LARGEST_STARTING_STATE).all()):
        raise InputError(
            "initial",
            must=f"have stretches from {1.0 / LARGEST_STARTING_STATE:g} to "
            f"{LARGEST_STARTING_STATE:g} and rates up to {LARGEST_STARTING_STATE:g}",
            got=state.tolist(),
            why="No motion gets beyond them, and high powers lose their digits there.",
            fix="Pass (1, 0) for rest.",
        )
    if not _is_admissible(system, values, states, field).all():
        raise InputError(
            "initial",
            must="be a state that the material can reach",
            got=state.tolist(),
            why=f"It lies beyond {system.describe_coordinate_limits()}.",
            fix="Start nearer to (1, 0), or raise the limit.",
        )


def _positive_variable_indices(field: Field) -> list[int]:
    """Positions of the state variables that only positive values make sense of."""
    return [k for k, variable in enumerate(field.variables) if variable.positive]


def _is_admissible(
    system: System, values: Mapping[str, FloatArray], states: FloatArray, field: Field
) -> BoolArray:
    """Whether the energies exist in each state, array (trajectory,) of bool."""
    coordinates = (states[:, k] for k in field.indices_of_roles(Role.COORDINATE))
    return system.where_admissible(values, *coordinates)
