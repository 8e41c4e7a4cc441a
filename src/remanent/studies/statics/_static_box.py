"""The box in which states of rest of a system of one's own are looked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from remanent._checks import require_mapping, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray, IntArray
from remanent.studies.ensemble.checks import require_interval
from remanent.studies.ensemble.ensemble import Ensemble

#: Why there is a box.
_REASON = "Nothing says by itself where a system of one's own may be at rest."


def require_static_box(
    box: Mapping[str, Any] | None, ens: Ensemble, unknown: IntArray
) -> FloatArray:
    """Bounds of the coordinates and internal variables, array (unknown, 2).

    Parameters
    ----------
    box : mapping of name to (lower, upper), or None
        What was passed for ``state_box``.
    ens : Ensemble
    unknown : array (unknown,) of int
        The state variables that rest determines.
    """
    names = [ens.vector_field.state_names[k] for k in unknown]
    fix = f"Pass state_box={{{', '.join(f'{n!r}: (low, high)' for n in names)}}}."
    given = require_mapping(
        "state_box", {} if box is None else box, what="state variables to two numbers", fix=fix
    )
    if {*given} != {*names}:
        raise InputError(
            "state_box",
            must=f"give bounds of {', '.join(names)}",
            got=shortened_repr(box),
            why=_REASON,
            fix=fix,
        )
    return np.array(
        [
            require_interval(
                f"state_box[{name!r}]", given[name], what="two increasing numbers", why=_REASON
            )
            for name in names
        ]
    )


def require_no_box(box: object) -> None:
    """Refuse a box for an actuator, whose equilibria are all found without one."""
    if box is not None:
        raise InputError(
            "state_box",
            must="be left out for an actuator",
            got=shortened_repr(box),
            why="All equilibria with stretches from 0.05 to 20 are found.",
            fix="Leave it out, and select from the result.",
        )
