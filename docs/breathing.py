"""Small free oscillations of an incompressible block, of any shape of deformation.

The model of the package lets a block deform homogeneously.  Here the displacement is any polynomial
up to a degree, free of divergence and with the symmetries of the breathing motion, by the method of
Ritz: the frequencies are upper bounds, which fall to the true ones as the degree grows.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, null_space

#: A polynomial: coefficients by the powers of x, y and z.
Polynomial = Mapping[tuple[int, int, int], float]
#: A displacement: its components along x, y and z.
Displacement = tuple[Polynomial, Polynomial, Polynomial]


def breathing_frequencies(slenderness: float, degree: int) -> NDArray[np.float64]:
    """Angular frequencies of the breathing motions of a free block, ascending.

    Parameters
    ----------
    slenderness : float
        H/L of the block 2 L x 2 L x 2 H.
    degree : int
        Of the polynomials.  Degree 1 is homogeneous deformation.

    Returns
    -------
    array (mode,)
        In radians per unit of time L (rho/mu)^(1/2).

    Notes
    -----
    Kinetic energy (1/2) u'.u' and strain energy e:e, e the symmetric gradient, integrated over the
    block, for displacements with div u = 0.
    """
    shapes = _symmetric_displacements(degree)
    strains = [_strain(shape) for shape in shapes]
    mass = _gram([list(shape) for shape in shapes], slenderness)
    stiffness = 2.0 * _gram(strains, slenderness)
    # Shapes of one size, so that thin blocks lose no digits.
    sizes = np.diag(1.0 / np.sqrt(np.diag(mass)))
    free = sizes @ null_space(_divergences(shapes) @ sizes)
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def _symmetric_displacements(degree: int) -> list[Displacement]:
    """Monomials that the exchange of x and y and reflections of the block leave as they are."""
    shapes: list[Displacement] = []
    for i, j, k in product(range(degree + 1), repeat=3):
        if i + j + k > degree:
            continue
        if i % 2 == 1 and j % 2 == 0 and k % 2 == 0:
            shapes.append(({(i, j, k): 1.0}, {(j, i, k): 1.0}, {}))
        if i % 2 == 0 and j % 2 == 0 and k % 2 == 1 and i <= j:
            shapes.append(({}, {}, {(i, j, k): 1.0, (j, i, k): 1.0}))
    return shapes


def _divergences(shapes: list[Displacement]) -> NDArray[np.float64]:
    """Coefficients of the divergence of each displacement, a column each."""
    divergences = [_sum(*(_derivative(shape[a], a) for a in range(3))) for shape in shapes]
    powers = sorted({power for divergence in divergences for power in divergence})
    return np.array([[divergence.get(p, 0.0) for divergence in divergences] for p in powers])


def _strain(shape: Displacement) -> list[Polynomial]:
    """The nine components of the symmetric gradient."""
    return [
        _sum(_derivative(shape[a], b), _derivative(shape[b], a), factor=0.5)
        for a, b in product(range(3), repeat=2)
    ]


def _derivative(polynomial: Polynomial, axis: int) -> Polynomial:
    return {
        tuple(p - (k == axis) for k, p in enumerate(power)): value * power[axis]  # type: ignore[misc]
        for power, value in polynomial.items()
        if power[axis] > 0
    }


def _sum(*polynomials: Polynomial, factor: float = 1.0) -> Polynomial:
    total: dict[tuple[int, int, int], float] = {}
    for polynomial in polynomials:
        for power, value in polynomial.items():
            total[power] = total.get(power, 0.0) + factor * value
    return total


def _gram(fields: list[list[Polynomial]], slenderness: float) -> NDArray[np.float64]:
    """Integrals over the block of the products of fields, summed over their components."""
    table = np.zeros((len(fields), len(fields)))
    for s, first in enumerate(fields):
        for r, second in enumerate(fields[: s + 1]):
            value = sum(_integral(f, g, slenderness) for f, g in zip(first, second, strict=True))
            table[s, r] = table[r, s] = value
    return table


def _integral(first: Polynomial, second: Polynomial, slenderness: float) -> float:
    return sum(
        a * b * _moment((p[0] + q[0], p[1] + q[1], p[2] + q[2]), slenderness)
        for p, a in first.items()
        for q, b in second.items()
    )


def _moment(power: tuple[int, int, int], slenderness: float) -> float:
    """Integral of x^i y^j z^k over |x| < 1, |y| < 1, |z| < slenderness."""
    i, j, k = power
    if i % 2 or j % 2 or k % 2:
        return 0.0
    return float(8.0 * slenderness ** (k + 1) / ((i + 1) * (j + 1) * (k + 1)))
