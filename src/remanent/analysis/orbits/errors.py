"""The errors of periodic orbits and of their multipliers: of all that moves them.

Let P be the exact iterate that closes an orbit, J its Jacobian at a point x near the orbit,
and d = P(x) - x the distance of the point from its image.  The orbit is at x + s with

    s = (1 - J)^-1 d,

up to second order, and d is not known: what is known is the computed distance, the residual,
to which the error of the computed map and rounding are added.  The error of a period is carried
on by the Jacobian of the periods after it.  All are multiplied by (1 - J)^-1, which is large near
bifurcations.

Newton's method with the Jacobian held, s -> s + (1 - J)^-1 (P(x + s) - x - s), maps a box around
x into itself and contracts it, if its half-widths w and the first-order error e satisfy

    e + Q(w, w)/2 <= w,    Q(w, w) < w,    Q = |(1 - J)^-1 P''|,

for each component; then exactly one orbit lies in the box (Banach's theorem; Krawczyk's test).
The components are those along the right singular vectors of 1 - J, since near a bifurcation one
of them is much less certain than the others.  Where there is no such box, no error is told:
points on a torus that nearly closes fail this test.

The Jacobian at the orbit differs from the computed one by the second derivatives of P times s, by
the error of the computed derivatives, and by rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.maps import Map
from remanent.analysis.orbits.period_chain import PeriodChain, matrices_times_vectors

#: Least distance over which Jacobians are differenced.
_MIN_DIFFERENCE_STEP = 1e-5
#: Longest distance: farther away second derivatives are others.
_MAX_DIFFERENCE_STEP = 1e-2
#: Largest contraction, with a margin for what the second derivatives leave out.
_MAX_CONTRACTION = 0.5
#: Iterations that find the box: beyond a contraction of 1/2 they converge slowly, or not.
_BOX_ITERATIONS = 40


@dataclass(frozen=True)
class OrbitErrors:
    """Periodic orbits near some points, and how well they are known.

    Attributes
    ----------
    state : array (orbit, state)
        The points.
    jacobian : array (orbit, state, state)
        Of the iterate that closes the orbit, at the points.
    residual : array (orbit,)
        Distance of the point from its image.
    newton_step : array (orbit, state)
        What Newton's method would add to the point.
    state_error : array (orbit, state)
        Of each variable of the state, as a bound: the step, the error of the map and rounding.
        NaN where the point is not shown to be near an orbit.
    map_share : array (orbit,)
        Largest part of `state_error` that is due to the steps of the integrator.
    rounding_share : array (orbit,)
        The same due to rounding.
    jacobian_error : array (orbit, state, state)
        Of each entry of the Jacobian, as that of the orbit.
    contraction : array (orbit,)
        Of Newton's method in the box of the error, as a bound: at most 1/2 where the orbit is
        confirmed.
    """

    state: FloatArray
    jacobian: FloatArray
    residual: FloatArray
    newton_step: FloatArray
    state_error: FloatArray
    map_share: FloatArray
    rounding_share: FloatArray
    jacobian_error: FloatArray
    contraction: FloatArray

    @property
    def is_confirmed(self) -> BoolArray:
        """Whether exactly one orbit lies near the point, array (orbit,)."""
        return np.asarray(self.contraction <= _MAX_CONTRACTION)

    @property
    def error(self) -> FloatArray:
        """Largest of `state_error` over the variables of the state, array (orbit,)."""
        return np.asarray(self.state_error.max(axis=1))


def orbit_errors(
    map_: Map, states: FloatArray, parameters: FloatArray, iterate: int
) -> OrbitErrors:
    """How far points are from periodic orbits, and their Jacobians from those of the orbits.

    Parameters
    ----------
    map_ : Map
        Each point is mapped period by period, and so are its neighbours at a small distance
        along each variable, for the second derivatives.
    states : array (orbit, state)
        Points to which Newton's method has converged.
    parameters : array (orbit, parameter)
    iterate : int
        Periods after which an orbit closes.
    """
    x = np.asarray(states, dtype=np.float64)
    count, d = x.shape
    if not count:
        none = np.empty((0, d, d))
        empty = np.empty(0)
        return OrbitErrors(x, none, empty, x, x, empty, empty, none, empty)
    with np.errstate(all="ignore"):
        chain = PeriodChain.along(map_, x, parameters, iterate)
        inverse = _inverse_or_nan(np.eye(d) - chain.jacobian)
        step = matrices_times_vectors(inverse, chain.end - x)
        axes = _right_singular_vectors(np.eye(d) - chain.jacobian)  # rows are the vectors
        from_map, map_share = _error_of_map(inverse, axes, chain)
        rounding, rounding_share = _error_of_rounding(inverse, axes, chain)
        first_order = np.abs(matrices_times_vectors(axes, step)) + from_map + rounding
        curvature = _second_derivatives(map_, chain, axes, parameters, iterate, first_order)
        bilinear = np.abs(np.einsum("nij,njlk,nml->nimk", axes @ inverse, curvature, axes))
        box = first_order
        for _ in range(_BOX_ITERATIONS):
            image = np.einsum("nijk,nj,nk->ni", bilinear, box, box)
            box = first_order + 0.5 * image
        contraction = (np.einsum("nijk,nj,nk->ni", bilinear, box, box) / box).max(axis=1)
        beyond = matrices_times_vectors(np.abs(axes.swapaxes(1, 2)), box - first_order)
        error = np.abs(step) + map_share + rounding_share + beyond
        jacobian_error = chain.jacobian_error + (np.abs(curvature) * box[:, None, None, :]).sum(3)
    contraction = np.where(first_order.max(axis=1) == 0.0, 0.0, contraction)
    contraction = np.where(np.isfinite(contraction), contraction, np.inf)
    error[~(contraction <= _MAX_CONTRACTION)] = np.nan
    residual = np.abs(chain.end - x).max(axis=1)
    return OrbitErrors(
        x, chain.jacobian, residual, step, error, map_share.max(axis=1), rounding_share.max(axis=1),
        jacobian_error, contraction,
    )  # fmt: skip


def _error_of_map(
    inverse: FloatArray, axes: FloatArray, chain: PeriodChain
) -> tuple[FloatArray, FloatArray]:
    """What the errors of the periods make of the orbit, along the axes and as it is."""
    parts = matrices_times_vectors(inverse[:, None] @ chain.later, chain.state_errors)
    along = np.abs(matrices_times_vectors(axes[:, None], parts))
    return along.sum(axis=1), np.abs(parts).sum(axis=1)


def _error_of_rounding(
    inverse: FloatArray, axes: FloatArray, chain: PeriodChain
) -> tuple[FloatArray, FloatArray]:
    """The same for rounding, whose sign is not known."""
    matrices = inverse[:, None] @ chain.later
    along = matrices_times_vectors(np.abs(axes[:, None] @ matrices), chain.roundings)
    parts = matrices_times_vectors(np.abs(matrices), chain.roundings)
    return along.sum(axis=1), parts.sum(axis=1)


def _second_derivatives(
    map_: Map,
    chain: PeriodChain,
    axes: FloatArray,
    parameters: FloatArray,
    iterate: int,
    reach: FloatArray,
) -> FloatArray:
    """Derivatives of the Jacobian along each axis, array (point, state, state, axis).

    They are differences over a distance that holds the error of the orbit.
    """
    count, d = chain.end.shape
    steps = np.fmax(reach, _MIN_DIFFERENCE_STEP).clip(None, _MAX_DIFFERENCE_STEP)
    places = chain.start[:, None, :] + steps[:, :, None] * axes
    derivative = map_(
        places.reshape(-1, d), np.repeat(parameters, d, axis=0), iterate
    ).jacobian.reshape(count, d, d, d)
    difference = (derivative - chain.jacobian[:, None]) / steps[:, :, None, None]
    return np.moveaxis(difference, 1, 3)


def _right_singular_vectors(matrices: FloatArray) -> FloatArray:
    """As rows; unit vectors where there are none."""
    vectors = np.broadcast_to(np.eye(matrices.shape[-1]), matrices.shape).copy()
    usable = np.isfinite(matrices).all(axis=(1, 2))
    vectors[usable] = np.linalg.svd(matrices[usable])[2]
    return vectors


def _inverse_or_nan(matrices: FloatArray) -> FloatArray:
    """Inverses; NaN where there is none."""
    usable: BoolArray = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
    usable[usable] = np.abs(np.linalg.det(matrices[usable])) > np.finfo(float).tiny
    inverse = np.full(matrices.shape, np.nan)
    inverse[usable] = np.linalg.inv(matrices[usable])
    return inverse
