"""Extremes between steps, from the Hermite polynomial through the ends of two steps."""

from __future__ import annotations

from typing import Any, NamedTuple


class TimeDerivatives(NamedTuple):
    """An observable at an instant: its value, and its first two derivatives by time."""

    value: Any
    rate: Any
    acceleration: Any


def three_node_hermite_coefficients(
    left: TimeDerivatives, middle: TimeDerivatives, right: TimeDerivatives, h: Any
) -> list[Any]:
    """Coefficients of the polynomial of degree 8 through three instants, h apart.

    Parameters
    ----------
    left, middle, right : TimeDerivatives
        Value and two time derivatives at t - h, t and t + h.
    h : number of any kind
        Distance of the nodes.

    Returns
    -------
    list of 9
        p(s) = sum of ``c[k] s**k`` with s = (time - t) / h.
    """
    # In units of h the derivatives are y, h y', h^2 y''.  Sums and differences of the outer
    # nodes split the 9 conditions into those for even and those for odd powers of s.
    scale = (1.0, h, h * h)
    (a, b, c), (d, e, f), (g, i, j) = (
        [x * w for x, w in zip(node, scale, strict=True)] for node in (left, middle, right)
    )
    c0, c1, c2 = d, e, 0.5 * f
    even = (0.5 * (g + a) - c0 - c2, 0.5 * (i - b) - 2.0 * c2, 0.5 * (j + c) - 2.0 * c2)
    odd = (0.5 * (g - a) - c1, 0.5 * (i + b) - c1, 0.5 * (j - c))
    c8 = 0.125 * (even[2] - 9.0 * even[1] + 24.0 * even[0])
    c6 = 0.5 * (even[1] - 4.0 * even[0]) - 2.0 * c8
    c7 = 0.125 * (odd[2] - 7.0 * odd[1] + 15.0 * odd[0])
    c5 = 0.5 * (odd[1] - 3.0 * odd[0]) - 2.0 * c7
    return [c0, c1, c2, odd[0] - c5 - c7, even[0] - c6 - c8, c5, c6, c7, c8]


def horner(coefficients: list[Any], s: Any) -> Any:
    """The polynomial with the given coefficients, lowest power first, at `s`."""
    total = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = total * s + c
    return total


def derivative_coefficients(coefficients: list[Any]) -> list[Any]:
    """Coefficients of the derivative."""
    return [float(k) * c for k, c in enumerate(coefficients)][1:]
