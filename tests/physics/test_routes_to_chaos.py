"""How the double well becomes chaotic: Feigenbaum's ratios and Melnikov's threshold."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import remanent as rm
from remanent._typing import FloatArray

#: x'' + delta x' - x + x^3 = m cos(omega t).
DOUBLE_WELL = rm.LagrangianSystem.example()
#: The same with x = scale z, so that z = 1 at rest starts where `scale` says.
SCALED_WELL = rm.LagrangianSystem(
    coordinates="z",
    kinetic="scale**2*z_rate**2/2",
    potential="-(scale*z)**2/2 + (scale*z)**4/4 - load*scale*z",
    dissipation="delta*scale**2*z_rate**2/2",
    parameters={"scale": np.sqrt(2.0), "delta": 0.05},
    rest={"z": 1.0},
)
COSINE = np.pi / 2.0
#: M. J. Feigenbaum, J. Stat. Phys. 19, 25 (1978).
FEIGENBAUM = 4.669201609102990
#: Drive frequency at which manifolds are looked at.
OMEGA = 2.0


def doublings(count: int) -> tuple[FloatArray, FloatArray]:
    """Amplitudes of the load at which the orbit in a well doubles, again and again, with errors.

    Each is looked for where the intervals so far lead, from where motion has come to.
    """
    system = DOUBLE_WELL.replace(parameters={"delta": 0.25})
    place, state, found, error = 0.1817, (0.375, 0.3615), [], []
    for n in range(count):
        drive, period = rm.Sine(place, 1.0, phase=COSINE), 2**n
        section = rm.poincare_section(
            system, drive, periods=100 * period, every=period, initial=state, tolerance=1e-6
        )
        state = float(section.x[-1]), float(section.x_rate[-1])
        point = rm.locate_bifurcation(
            system, drive, "period doubling", "m", initial=state, orbit_period=period
        )
        found.append(float(point.m))
        error.append(float(point.m_error))
        state = float(point.x), float(point.x_rate)
        last = found[-1] - found[-2] if n else 0.029
        place = found[-1] + last / 4.7
    return np.array(found), np.array(error)


def test_the_ratios_of_feigenbaum() -> None:
    """Intervals between doublings shrink by 4.6692, the nearer the more have gone before.

    The first three doublings are those that AUTO-07p found, refined in extended precision.
    """
    found, error = doublings(7)
    interval, interval_error = np.diff(found), error[1:] + error[:-1]
    ratio = interval[:-1] / interval[1:]
    share = interval_error / interval
    ratio_error = ratio * (share[:-1] + share[1:])
    away = np.abs(ratio - FEIGENBAUM)
    assert away[-1] <= ratio_error[-1] < 0.01
    assert (away[2:-1] < away[1:-2] / 2.0).all()
    assert (ratio_error[:-1] < 1e-3).all()
    path = Path(__file__).parents[1] / "literature" / "auto" / "reference" / "double_well.json"
    known = [one["F"] for one in json.loads(path.read_text())["special"] if one["kind"] == "PD"]
    assert (np.abs(found[:3] - known) <= error[:3]).all()


def melnikov_threshold(delta: float) -> float:
    """Where Melnikov's function first has a zero, to first order in delta.

    On x = sqrt(2) sech t it is M(psi) = -4 delta/3 + m sqrt(2) pi omega sech(pi omega/2) sin psi
    for the load m cos(omega t + psi).
    """
    return float(4.0 * delta / (3.0 * np.sqrt(2.0) * np.pi * OMEGA) * np.cosh(np.pi * OMEGA / 2.0))


def place_on_stable_manifold(delta: float, m: float, psi: float) -> tuple[float, float]:
    """Where the stable manifold of the saddle crosses x' = 0 near sqrt(2), and its error."""
    hill = m * np.exp(1j * psi) / (-(OMEGA**2) - 1.0 + 1j * delta * OMEGA)  # linear about x = 0
    middle, reach = np.sqrt(2.0), 0.5 * abs(delta)
    found = rm.manifold_crossing(
        SCALED_WELL.replace(parameters={"delta": delta}),
        rm.Sine(m, OMEGA, phase=psi + COSINE),
        "scale",
        (middle - reach, middle + reach),
        saddle=np.array([hill.real, (1j * OMEGA * hill).real]) / middle,
        periods=60,
        width=1e-7,
    )
    return float(found.scale), float(found.scale_error)


def gap(delta: float, m: float, psi: float) -> tuple[float, float]:
    """From the unstable to the stable manifold on x' = 0: negative where they have crossed.

    Backwards in time the unstable manifold is the stable one of the damping -delta, phase -psi.
    """
    (stable, error), (unstable, other) = (
        place_on_stable_manifold(sign * delta, m, sign * psi) for sign in (1.0, -1.0)
    )
    return stable - unstable, error + other


def measured_threshold(delta: float) -> tuple[float, float]:
    """The least m at which the manifolds touch, over all phases, with its error.

    At each of three phases the gap is linear in m over a tenth of it; a parabola has the least.
    """
    guess, offsets = melnikov_threshold(delta), np.array([-0.25, 0.0, 0.25])
    thresholds, errors = [], []
    for psi in np.pi / 2.0 + offsets:
        (low, low_error), (high, high_error) = (gap(delta, m, psi) for m in (guess, 1.1 * guess))
        slope = (high - low) / (0.1 * guess)
        thresholds.append(guess - low / slope)
        errors.append((low_error + high_error) / abs(slope))
    curvature, tilt, level = np.polyfit(offsets, thresholds, 2)
    assert curvature > 0.0
    return float(level - tilt**2 / (4.0 * curvature)), max(errors)


@pytest.mark.slow
def test_the_threshold_of_melnikov() -> None:
    """m_c over Melnikov's tends to 1; what is left falls to a quarter where delta is halved.

    Backwards in time delta changes its sign and the threshold stays, so that m_c over the size of
    delta is even in delta: there is no term of first order.
    """
    left = []
    for delta in (0.04, 0.02, 0.01):
        found, error = measured_threshold(delta)
        assert error / found < 1e-5
        left.append(abs(found / melnikov_threshold(delta) - 1.0))
    assert left[-1] < 5e-5
    for coarse, fine in pairwise(left):
        assert 3.5 < coarse / fine < 4.5
