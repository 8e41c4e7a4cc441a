"""From one branch to another where they cross: doublings, and loss of a symmetry.

Where branches cross, the derivatives of the equations lose a rank: beside the tangent of the
one branch there is a second null vector, along which the other leaves.  At a period
doubling that holds for the equations of twice the period.

References
----------
Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (Springer, 2004), chapter 10.
"""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import CurveEquations, CurvePoints

#: Lengths tried along the second null vector, in scaled unknowns.
_TRIAL_LENGTHS = (0.01, 0.003, 0.03, 0.001)
#: A point farther than this many lengths from the crossing is on a third branch.
_MAX_DISTANCE_IN_TRIAL_LENGTHS = 3.0


def find_point_on_crossing_branch(
    equations: CurveEquations, crossing: FloatArray, *, scale: FloatArray, tolerance: float
) -> CurvePoints | None:
    """A point of the branch that crosses another one; None where none is reached.

    Parameters
    ----------
    equations : callable
        Of the branch to be found: at a period doubling, of twice the period.
    crossing : array (n + 1,)
        Where both meet; the last unknown is the parameter, and the first branch does not
        turn back there.
    scale : array (n + 1,)
        Units of the unknowns.
    tolerance : float
        Of the equations.

    Notes
    -----
    The tangent of the first branch is the null vector with a part along the parameter; the
    other branch of a doubling or of a broken symmetry starts across it, as a parabola.
    """
    crossing_values = equations(crossing[None])
    _, _, right = np.linalg.svd(crossing_values.derivative[0] * scale)
    # Of the plane of null vectors, the one along which the parameter stays.
    plane = right[-2:]
    crossing_direction = plane[1, -1] * plane[0] - plane[0, -1] * plane[1]
    crossing_direction /= np.linalg.norm(crossing_direction)
    for length in _TRIAL_LENGTHS:
        guess = crossing + length * crossing_direction * scale
        points, reached = correct_points(
            equations, guess[None], crossing_direction[None], scale=scale, tolerance=tolerance
        )
        displacement = (points.unknown[0] - crossing) / scale
        # It lies in the plane across the vector at this length: not on the branch that is known.
        is_close = np.linalg.norm(displacement) < _MAX_DISTANCE_IN_TRIAL_LENGTHS * length
        if reached[0] and is_close:
            return points
    return None
