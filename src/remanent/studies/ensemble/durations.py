"""How long a run lasts, in tau or in drive periods."""

from __future__ import annotations

from typing import Any

import numpy as np

from remanent._checks import Rule, is_integer, require_real, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.studies.ensemble.ensemble import Ensemble

#: Larger integers are not exact in double precision.
_LARGEST_EXACT_COUNT = 2**53
#: Default length of the window of a response, in units of tau: that of [Thermal].
DEFAULT_RESPONSE_DURATION_IN_TAU = 100.0
#: The steps of shorter runs have lengths that lose digits, down to 0.
_SHORTEST_RUN = float(np.finfo(np.float64).tiny)
_DURATION_RULE = Rule(
    f"be a finite number greater than 0, at least {_SHORTEST_RUN:.1e}",
    lambda x: x >= _SHORTEST_RUN,
    "A run takes a positive time.",
    "Pass a time in units of tau.",
)


def require_count(name: str, value: Any, why: str, least: int = 1) -> int:
    """`value` as an integer not below `least`.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
        What was passed for it.
    why : str
        What is counted, a sentence.
    least : int
        Least number allowed.
    """
    if not is_integer(value) or value < least:
        raise InputError(
            name,
            must="be a positive integer" if least == 1 else f"be an integer, at least {least}",
            got=shortened_repr(value),
            why=why,
            fix=f"Pass a whole number, at least {least}.",
        )
    if value > _LARGEST_EXACT_COUNT:
        raise InputError(
            name,
            must=f"be at most {_LARGEST_EXACT_COUNT}",
            got=f"a number of {len(str(value))} digits",
            why=why,
            fix="Pass as many as a computer can take.",
        )
    return int(value)


def require_drive_periods(ens: Ensemble) -> FloatArray:
    """The drive period of every trajectory, array (trajectory,); raises where there is none.

    For verbs that make no sense without a periodic load.
    """
    periods = ens.drive_periods()
    if periods is None:
        raise InputError(
            "drive",
            must="have a period",
            got=f"a {type(ens.drive).__name__} drive",
            why="What is computed is counted in periods of the load.",
            fix="Pass rm.Sine or rm.SineSquared.",
        )
    return periods


def require_duration(duration: object) -> float:
    """The length of a run in units of tau."""
    return require_real("duration", duration, _DURATION_RULE)


def trajectory_durations(ens: Ensemble, duration: float | None, periods: int | None) -> FloatArray:
    """Length of every trajectory, array (trajectory,), from one of `duration` and `periods`.

    For verbs that take both, of which exactly one is given.
    """
    if periods is None:
        return np.broadcast_to(require_duration(duration), ens.trajectory_count)
    count = require_count("periods", periods, "Runs are counted in whole drive periods.")
    lengths = ens.drive_periods()
    if lengths is None:
        raise InputError(
            "periods",
            must="be left out for a drive without a period",
            got=f"{count} with a {type(ens.drive).__name__} drive",
            why="Only a load that repeats itself has drive periods to count.",
            fix="Pass `duration` instead, or use rm.Sine or rm.SineSquared.",
        )
    return count * lengths


def require_exactly_one_argument(**given: Any) -> None:
    """Exactly one of the arguments must not be None."""
    present = [name for name, value in given.items() if value is not None]
    if len(present) != 1:
        names = ", ".join(f"`{name}`" for name in given)
        raise InputError(
            present[0] if present else next(iter(given)),
            must=f"be the only one of {names}, exactly one of which is given",
            got=" and ".join(present) or "none of them",
            why="Each of them alone says how long the run is.",
            fix="Pass one of them.",
        )
