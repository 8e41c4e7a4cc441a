"""[Thermal, eq. 16] by heyoka.py in extended precision: what errors are measured against.

The equation and the loads are written out here once more, from [Thermal] and from the
documentation of the drives.  Of the package only the values of its own fields are used,
and the coefficients of the spline that defines a sampled signal.  With 64 bits of
mantissa the reference errs 2000 times less than anything in double precision, however
the motion magnifies errors, so its own error never decides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np

from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.drives.chirp import Chirp
from remanent.models.drives.piecewise import PiecewiseDrive
from remanent.models.drives.waves import Constant, Sine, SineSquared

#: Extended precision, 64 bits of mantissa on x86.
LONG = np.longdouble
#: Relative error of a step.
PRECISION = 1e-19
# Load laws of the numbers a0 ... a3 and the time t since the piece began.
#: a0 + a1 t + a2 t² + a3 t³.
CUBIC = "cubic"
#: mean + a3 sin(a0 + a1 t + a2 t²).
WAVE = "wave"
#: (a3 sin(a0 + a1 t + a2 t²))².
SQUARED = "squared"


@dataclass(frozen=True)
class Piece:
    """A stretch of time on which the load is smooth, and its five numbers."""

    begin: Any
    end: Any
    numbers: tuple[Any, ...]


@dataclass(frozen=True)
class Motion:
    """One trajectory: numbers of the actuator, the drive with its values, where it starts.

    Attributes
    ----------
    values : mapping of name to float
        Numeric fields of actuator and drive as the package takes them.
    """

    drive: Drive
    values: Mapping[str, float]
    initial: tuple[float, float] = (1.0, 0.0)

    @property
    def body(self) -> list[Any]:
        """c, theta, S and eta; theta is a quotient, so it is formed with all digits."""
        v = self.values
        theta = LONG(v["temperature"]) / LONG(v["reference_temperature"])
        return [v["c"], theta, v["prestress"], v.get("dissipation.0.eta", 0.0)]


def law(drive: Drive) -> str:
    """The name of the load law that a drive follows."""
    if isinstance(drive, SineSquared):
        return SQUARED
    return WAVE if isinstance(drive, Sine | Chirp) else CUBIC


def pieces(drive: Drive, values: Mapping[str, float], duration: float) -> list[Piece]:
    """The load from 0 to `duration`."""
    end, v = LONG(duration), {name: LONG(value) for name, value in values.items()}
    if isinstance(drive, Constant):
        return [Piece(LONG(0), end, (v["m"], 0, 0, 0, 0))]
    if isinstance(drive, SineSquared):
        return [Piece(LONG(0), end, (v["phase"], v["omega"], 0, v["b"], 0))]
    if isinstance(drive, Sine):
        return [Piece(LONG(0), end, (v["phase"], v["omega"], 0, v["m"], v["mean"]))]
    if isinstance(drive, Chirp):
        return _swept(v, end)
    if isinstance(drive, PiecewiseDrive):
        marks = [LONG(t) for t in drive.times if t < duration] + [end]
        columns = drive.piece_coefficients().T
        return [Piece(a, b, (*columns[k], 0)) for k, (a, b) in enumerate(pairwise(marks))]
    raise TypeError(f"no load law for {type(drive).__name__}")


def _swept(v: Mapping[str, Any], end: Any) -> list[Piece]:
    sweep, rest = v["duration"], (v["m"], v["mean"])
    curvature = (v["stop"] - v["start"]) / (2 * sweep)
    first = Piece(LONG(0), min(sweep, end), (v["phase"], v["start"], curvature, *rest))
    turned = v["phase"] + (v["start"] + v["stop"]) / 2 * sweep
    held = Piece(sweep, end, (turned, v["stop"], 0, *rest))
    return [first, held] if end > sweep else [first]


@cache
def _engine(kind: str, events: bool) -> tuple[Any, list[Any]]:
    """An integrator of a load law, and the list in which it notes stretches that turn."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, eta, a0, a1, a2, a3, mean = (hy.par[k] for k in range(9))
    t = hy.time
    if kind == CUBIC:
        m = a0 + t * (a1 + t * (a2 + t * a3))
    else:
        sine = a3 * hy.sin(a0 + t * (a1 + t * a2))
        m = sine * sine if kind == SQUARED else mean + sine
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + m * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    turning_points: list[Any] = []

    def record(ta: Any, time: Any, _sign: int) -> None:
        ta.update_d_output(time)
        turning_points.append(ta.d_output[0])

    engine = hy.taylor_adaptive(
        [(x, v), (v, rate)], np.array([1, 0], dtype=LONG), fp_type=LONG,
        tol=LONG(PRECISION), nt_events=[hy.nt_event(v, record, fp_type=LONG)] if events else [],
    )  # fmt: skip
    return engine, turning_points


def states(motion: Motion, times: FloatArray) -> FloatArray:
    """Stretch and rate at ascending `times` from 0 on, an array (time, 2)."""
    engine, _ = _engine(law(motion.drive), False)
    engine.state[:] = motion.initial
    result = np.full((times.size, 2), np.nan)
    for piece in pieces(motion.drive, motion.values, float(times[-1])):
        _begin(engine, motion, piece)
        inside = np.flatnonzero((times >= piece.begin) & (times <= piece.end))
        # The ends of a piece are in its grid too: the next piece starts from the last state.
        local = times[inside].astype(LONG) - piece.begin
        grid = np.unique(np.array([LONG(0), *local, piece.end - piece.begin]))
        path = engine.propagate_grid(grid)[-1]
        result[inside] = path[np.searchsorted(grid, local)]
        engine.state[:] = path[-1]
    return result


def extremes(motion: Motion, begin: float, end: float) -> tuple[float, float]:
    """Largest and smallest thickness stretch between `begin` and `end`."""
    engine, turning_points = _engine(law(motion.drive), True)
    engine.state[:] = motion.initial
    stretches: list[Any] = []
    for piece in pieces(motion.drive, motion.values, end):
        _begin(engine, motion, piece)
        if piece.begin < begin:
            engine.propagate_until(min(LONG(begin), piece.end) - piece.begin)
        if piece.end > begin:
            turning_points.clear()
            start = engine.state[0]
            engine.propagate_until(piece.end - piece.begin)
            stretches += [start, *turning_points, engine.state[0]]
    thickness = np.array(stretches, dtype=LONG) ** -2
    return float(thickness.max()), float(thickness.min())


def _begin(engine: Any, motion: Motion, piece: Piece) -> None:
    engine.time = LONG(0)
    numbers = [*motion.body, *piece.numbers]
    engine.pars[:] = numbers[: len(engine.pars)]  # not every law has a mean
