"""Rules for arguments that all verbs share."""

from __future__ import annotations

import numpy as np

from remanent._checks import Rule, require_real
from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.models.system import System

#: Below this, round-off in double precision is all that is left.
FINEST = 1e-13

_TOLERANCE = Rule(
    f"lie between {FINEST:g} and 0.1",
    lambda x: np.asarray((x >= FINEST) & (x <= 0.1)),
    "It is asked of the absolute global error, in double precision.",
    "Pass for example 1e-9.",
)


def require_tolerance(value: object) -> float:
    """A tolerance that double precision can meet."""
    return require_real("tolerance", value, _TOLERANCE)


def require_system(system: object) -> System:
    """Whatever has the members of a system; its equations are found by its kind."""
    if not isinstance(system, System):
        raise InputError(
            "system",
            "be a system that can move",
            repr(system)[:80],
            "The equations of motion are derived from it.",
            "Pass for example rm.Actuator().",
        )
    return system


def require_actuator(name: str, system: object) -> Actuator:
    """An actuator, for what only that has: stretches, scales, shaping."""
    if not isinstance(system, Actuator):
        raise InputError(
            name,
            "be an actuator",
            repr(system)[:80],
            "Only an actuator has in-plane stretches, dead loads and a magnetic load.",
            "Pass for example rm.Actuator().",
        )
    return system
