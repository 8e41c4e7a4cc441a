"""Rules for arguments that all verbs share."""

from __future__ import annotations

import numpy as np

from remanent._checks import Rule, require_real

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
