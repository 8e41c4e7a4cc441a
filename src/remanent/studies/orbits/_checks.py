"""Rules for arguments of the verbs for periodic orbits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from remanent._checks import as_float_array, shortened_repr
from remanent._errors import InputError
from remanent._field import Role, StateVariable
from remanent._typing import FloatArray
from remanent.models.actuator import Actuator
from remanent.studies.ensemble.durations import require_count
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.initial import default_initial_values

#: Default range of stretches.
DEFAULT_STRETCH_RANGE = (0.3, 4.0)
#: Default range of rates of stretches.
DEFAULT_RATE_RANGE = (-8.0, 8.0)
#: Kelvin around the surroundings in which a body's temperature is looked for.
TEMPERATURE_MARGIN_KELVIN = 5.0
#: Special points that are looked for by themselves.
BIFURCATION_KINDS = ("fold", "period doubling")
#: Largest state that a box may hold.
_LARGEST_STATE = 1e100
#: Longest period of an orbit, in drive periods.
_LONGEST_ORBIT_PERIOD = 4096
#: Most frequencies at which orbits are looked for in one call.
_MOST_SLICES = 10_000
#: Why there is a box.
_STATE_BOX_REASON = "Orbits are looked for, and branches end, in a box of states at phase 0."
_STATE_BOX_REMEDY = "Pass for example {'stretch': (0.3, 4.0)}, by the names of the states."


def require_state_box(name: str, box: Mapping[str, Any] | None, ens: Ensemble) -> FloatArray:
    """Lower and upper bound of every state variable, array (state, 2).

    Parameters
    ----------
    name : str
        Name of the argument.
    box : mapping of name to (lower, upper), or None
        What was passed for it.  State variables that it leaves out have default bounds.
    ens : Ensemble
        By default a temperature is looked for around that of its first valid trajectory.
    """
    if box is not None and not isinstance(box, Mapping):
        raise InputError(
            name,
            must="be a mapping of state variables to pairs of numbers",
            got=shortened_repr(box),
            why=_STATE_BOX_REASON,
            fix=_STATE_BOX_REMEDY,
        )
    given, state = dict(box or {}), ens.vector_field.state_names
    for variable in given:
        if variable not in state:
            raise InputError(
                name,
                must=f"name state variables, {', '.join(state)}",
                got=shortened_repr(variable),
                why=_STATE_BOX_REASON,
                fix=_STATE_BOX_REMEDY,
            )
    return np.array(
        [
            _require_bounds(name, variable, given[variable.name])
            if variable.name in given
            else _default_bounds(name, variable, ens)
            for variable in ens.vector_field.variables
        ]
    )


def _require_bounds(name: str, variable: StateVariable, bounds: Any) -> FloatArray:
    """The two bounds that were given for one state variable."""
    rule = f"give {variable.name} a lower and a larger upper number"
    pair = as_float_array(
        f"{name}[{variable.name!r}]",
        bounds,
        what="two numbers",
        why=_STATE_BOX_REASON,
        fix=_STATE_BOX_REMEDY,
    )
    if pair.shape != (2,) or not np.isfinite(pair).all() or not pair[0] < pair[1]:
        raise InputError(
            name,
            must=rule,
            got=shortened_repr(bounds),
            why=_STATE_BOX_REASON,
            fix=_STATE_BOX_REMEDY,
        )
    if np.abs(pair).max() > _LARGEST_STATE:
        raise InputError(
            name,
            must=f"keep {variable.name} below {_LARGEST_STATE:g} in size",
            got=shortened_repr(bounds),
            why="No orbit is so large, and a finer division of the box would not reach it.",
            fix=_STATE_BOX_REMEDY,
        )
    if variable.positive and pair[0] <= 0.0:
        raise InputError(
            name,
            must=f"keep {variable.name} above 0",
            got=float(pair[0]),
            why="A stretch is a ratio of lengths, a temperature is absolute.",
            fix=_STATE_BOX_REMEDY,
        )
    return pair


def _default_bounds(name: str, variable: StateVariable, ens: Ensemble) -> FloatArray:
    """The bounds of a state variable that none were given for."""
    if not isinstance(ens.system, Actuator):
        names = ens.vector_field.state_names
        raise InputError(
            name,
            must=f"give bounds of {', '.join(names)}",
            got=f"none of {variable.name}",
            why="Nothing says by itself where orbits of a system of one's own may be.",
            fix=f"Pass {{{', '.join(f'{n!r}: (low, high)' for n in names)}}}.",
        )
    if variable.role is Role.RATE:
        return np.array(DEFAULT_RATE_RANGE)
    if variable.role is not Role.TEMPERATURE:
        return np.array(DEFAULT_STRETCH_RANGE)
    valid = np.flatnonzero(~ens.is_invalid)
    if not valid.size:  # nothing is computed
        return np.array([0.0, 1.0])
    surroundings = float(
        default_initial_values(variable, ens.parameter_values, ens.trajectory_count)[valid[0]]
    )
    if not np.isfinite(surroundings):
        raise InputError(
            name,
            must=f"give {variable.name} two bounds",
            got=f"none, and a temperature of {surroundings} around the body",
            why="By default they lie around the temperature of the surroundings.",
            fix=f"Pass {{{variable.name!r}: (290.0, 300.0)}}, or a finite temperature.",
        )
    return np.array(
        [surroundings - TEMPERATURE_MARGIN_KELVIN, surroundings + TEMPERATURE_MARGIN_KELVIN]
    )


def require_heat_exchange(ens: Ensemble) -> None:
    """Refuse adiabatic bodies: they warm for ever, or have an orbit for each entropy."""
    warms = bool(ens.vector_field.indices_of_roles(Role.TEMPERATURE))
    if warms and not (ens.parameter_values["heat.exchange"] > 0.0).all():
        raise InputError(
            "system",
            must="exchange heat where its temperature is a state",
            got=ens.system,
            why="Without exchange it warms for ever, or has an orbit for every temperature.",
            fix="Pass rm.Heat(exchange=...) above 0, or heat=None.",
        )


def require_orbit_period(value: object, name: str = "orbit_period") -> int:
    """The period of an orbit in drive periods."""
    period = require_count(name, value, "Orbits close after whole drive periods.")
    if period > _LONGEST_ORBIT_PERIOD:
        raise InputError(
            name,
            must=f"be at most {_LONGEST_ORBIT_PERIOD}",
            got=period,
            why="Each step towards an orbit follows the motion for so many drive periods.",
            fix="Pass the period of an orbit that was seen, for example by regime_chart.",
        )
    return period


def require_slices(value: object) -> int:
    """The number of frequencies at which orbits are looked for."""
    slices = require_count("slices", value, "Orbits are looked for at each of them.")
    if slices > _MOST_SLICES:
        raise InputError(
            "slices",
            must=f"be at most {_MOST_SLICES}",
            got=slices,
            why="Each is a search for orbits of its own, of a second or so.",
            fix="Pass fewer, or split the range of frequencies.",
        )
    return slices


def require_not_in_over(parameters: tuple[str, ...], ens: Ensemble) -> None:
    """Refuse `over` that varies a field which varies along a curve, or is solved for."""
    for parameter in parameters:
        if parameter in ens.coords:
            raise InputError(
                "over",
                must=f"not name {parameter}",
                got=shortened_repr(parameter),
                why="It is the field that is varied to find the result.",
                fix="Leave it out of `over`.",
            )
