"""How long a run lasts, in tau or in drive periods."""

from __future__ import annotations

from typing import Any

import numpy as np

from remanent._checks import Rule, positive, require_real
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.studies.ensemble.ensemble import Ensemble

#: Larger integers are not exact in double precision.
_MOST = 2**53
_TIME: Rule = positive("A run takes a positive time.", "Pass a time in units of tau.")


def require_count(name: str, value: Any, why: str, least: int = 1) -> int:
    """`value` as an integer not below `least`."""
    if isinstance(value, int | np.integer) and value > _MOST:
        raise InputError(
            name,
            must=f"be at most {_MOST}",
            got="more",
            why=why,
            fix="Pass as many as a computer can take.",
        )
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(
            name,
            must="be a positive integer" if least == 1 else f"be an integer, at least {least}",
            got=repr(value),
            why=why,
            fix=f"Pass at least {least}.",
        )
    return int(value)


def require_periods(ens: Ensemble) -> FloatArray:
    """The drive period of every trajectory; raises where the load has none."""
    periods = ens.periods()
    if periods is None:
        raise InputError(
            "periods",
            must="be left out for a drive without a period",
            got=f"a {type(ens.drive).__name__} drive",
            why="Only a load that repeats itself has drive periods to count.",
            fix="Pass `duration` instead, or use rm.Sine or rm.SineSquared.",
        )
    return periods


def durations(ens: Ensemble, duration: Any, periods: Any) -> FloatArray:
    """Length of every trajectory from exactly one of `duration` and `periods`."""
    if periods is not None:
        count = require_count("periods", periods, "Runs are counted in whole drive periods.")
        return count * require_periods(ens)
    return np.broadcast_to(require_real("duration", duration, _TIME), ens.count)


def require_one(**given: Any) -> None:
    """Exactly one of the arguments must not be None."""
    present = [name for name, value in given.items() if value is not None]
    if len(present) != 1:
        names = ", ".join(f"`{name}`" for name in given)
        raise InputError(
            " / ".join(given),
            must=f"be given as exactly one of {names}",
            got=" and ".join(present) or "none of them",
            why="Each of them alone says how long the run is.",
            fix="Pass one of them.",
        )
