"""The top of a smooth function of which some values are known, with errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Chebyshev

from remanent._typing import FloatArray

#: Degree of the polynomial with which that through all values is compared.
_LOWER_DEGREE = 6
#: Share of the bound of the noise in a top from which on it is no use to look more closely:
#: bounds of amplitudes and of orbits are some fifty times their errors, and errors at
#: neighbouring nodes are alike.
_NOISE_SHARE = 0.05
#: Weights of what a top may be off by: of what polynomials of two degrees differ by, of the noise
#: that the highest coefficients show, which are two, so that it is known as Student's t of two
#: degrees of freedom has it, and of the noise as the bound of the amplitudes has it, which
#: stands for errors that change slowly along the curve.
_CUT_OFF_WEIGHT = 4.0
_SEEN_NOISE_WEIGHT = 8.0
_NOISE_WEIGHT = 0.015
#: Rounding of an amplitude: of two stretches of the order of one.
_ROUNDING = 0.5 * float(np.finfo(float).eps)
#: Distance of the point beyond the ends of the nodes, as a share of their half width, from
#: which a peak does not count as between them.
_SLACK = 1.0 + 1e-6


@dataclass(frozen=True)
class Top:
    """Where a polynomial through values is largest, and what moves that place.

    Attributes
    ----------
    place : float
    cut_off : float
        Distance from the top of a polynomial of lower degree.
    seen_noise, noise : float
        What independent errors of the values make of the root of the derivative, as large as the
        coefficients above that degree show them, and as a share of their bound.
    """

    place: float
    cut_off: float
    seen_noise: float
    noise: float

    @property
    def error(self) -> float:
        return (
            _CUT_OFF_WEIGHT * self.cut_off
            + _SEEN_NOISE_WEIGHT * self.seen_noise
            + _NOISE_WEIGHT * self.noise
        )


def top_of_polynomials(x: FloatArray, values: FloatArray, error: float) -> Top | None:
    """The top of a polynomial through values at Chebyshev's nodes; None if it is not between them.

    A root of the derivative moves by the error of the slope over the curvature.  Independent
    errors s of the n values make sqrt(2/n) s of each coefficient.
    """
    ends = [float(x.min()), float(x.max())]
    reach, middle = 0.5 * (ends[1] - ends[0]), 0.5 * sum(ends)
    fits = [Chebyshev.fit(x, values, degree, domain=ends) for degree in (x.size - 1, _LOWER_DEGREE)]
    tops = []
    for fit in fits:
        roots = fit.deriv().roots()
        real = roots[np.abs(roots.imag) < 1e-7 * reach].real
        inside = real[np.abs(real - middle) <= _SLACK * reach]
        if not inside.size:
            return None
        tops.append(float(inside[np.argmax(fit(inside))]))
    curvature = float(fits[0].deriv(2)(tops[0]))
    if not curvature < 0.0:
        return None
    # How the slope at the top depends on each of the values.
    unit = [
        Chebyshev.fit(x, row, x.size - 1, domain=ends).deriv()(tops[0]) for row in np.eye(x.size)
    ]
    moved = float(np.linalg.norm(unit)) / abs(curvature)
    highest = np.asarray(fits[0].coef[_LOWER_DEGREE + 1 :], dtype=np.float64)
    seen = float(np.sqrt(0.5 * x.size * np.mean(highest**2))) + _ROUNDING
    return Top(tops[0], abs(tops[0] - tops[1]), moved * seen, moved * _NOISE_SHARE * error)
