"""Rules for arguments that many verbs share."""

from __future__ import annotations

import numpy as np

from remanent._checks import Rule, as_float_array, require_choice, require_real, shortened
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.studies.ensemble.ensemble import Ensemble

#: Below this, round-off in double precision is all that is left.
FINEST = 1e-13
#: Above this, an error bound says nothing.
COARSEST = 0.1
#: The seed of all random choices where none is given.
_SEED = 0
#: Seeds that are drawn from a generator are smaller than this.
_SEED_LIMIT = 2**31


def require_tolerance(value: object, of: str = "the absolute global error") -> float:
    """A tolerance that double precision can meet.

    Parameters
    ----------
    value : object
        What was passed for ``tolerance``.
    of : str
        What it is asked of, as in ``"the residual"``.
    """
    rule = Rule(
        f"lie between {FINEST:g} and {COARSEST:g}",
        lambda x: np.asarray((x >= FINEST) & (x <= COARSEST)),
        f"It is asked of {of}, in double precision.",
        "Pass for example 1e-9.",
    )
    return require_real("tolerance", value, rule)


def require_range(
    name: str, value: object, parameter: str, ens: Ensemble, why: str
) -> tuple[float, float]:
    """The lowest and the highest value of a numeric field.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
        What was passed for it.
    parameter : str
        The field.
    ens : Ensemble
        Its system or its drive has the field.
    why : str
        What happens between the two values, a sentence.

    Raises
    ------
    InputError
        If it is not two increasing numbers that the field may take.
    """
    what, fix = f"the lowest and the highest value of {parameter}", "Pass two increasing numbers."
    pair = as_float_array(name, value, what=what, why=why, fix=fix, ndim=1, finite=True)
    if pair.size != 2 or not pair[0] < pair[1]:
        raise InputError(name, must=f"be {what}", got=shortened(value), why=why, fix=fix)
    for end in pair:
        broken = ens.system.invalid({parameter: end}) | ens.drive.invalid({parameter: end})
        if broken.any():
            raise InputError(
                name,
                must=f"hold possible values of {parameter} only",
                got=float(end),
                why=why,
                fix="Pass values within the field's own range.",
            )
    return float(pair[0]), float(pair[1])


def require_parameter(name: str, value: object, ens: Ensemble) -> str:
    """The name of a numeric field of the system or of the drive."""
    return require_choice(name, value, list(ens.values))


def require_state(name: str, value: ArrayLike, ens: Ensemble, *, why: str, fix: str) -> FloatArray:
    """All state variables of one point, array (state,)."""
    names = ens.field.state
    state = as_float_array(name, value, what=", ".join(names), why=why, fix=fix, finite=True)
    if state.size != len(names):
        raise InputError(
            name,
            must=f"be {len(names)} numbers, ({', '.join(names)})",
            got=shortened(value),
            why=why,
            fix=fix,
        )
    return state.ravel()


def as_seed(rng: int | np.random.Generator | None) -> int:
    """The seed of the random choices of one call: fixed where nothing is given.

    Choices are then drawn for each point from this seed and the point alone, so that they do
    not depend on the batch or tile that the point is in.  A generator gives its next number:
    it moves on, as whoever passes one expects.
    """
    if rng is None:
        return _SEED
    if isinstance(rng, np.random.Generator):
        return int(rng.integers(_SEED_LIMIT))
    if isinstance(rng, bool | np.bool_) or not isinstance(rng, int | np.integer) or rng < 0:
        raise InputError(
            "rng",
            must="be an integer that is not negative, or a numpy.random.Generator",
            got=shortened(rng),
            why="Equal seeds give equal results.",
            fix="Pass for example 1, or leave it out for one fixed seed.",
        )
    return int(rng)
