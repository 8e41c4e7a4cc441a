"""SciPy's root and minimum finders that work on many brackets at once, with types.

The stubs of SciPy do not know the argument `args`; here is the one place that says so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from scipy.optimize import elementwise

from remanent._typing import BoolArray, FloatArray

#: ``f(x, *args)`` with arrays (bracket,) of which any part may be passed.
ElementwiseFunction = Callable[..., Any]


class Roots(Protocol):
    """What is found in every bracket, arrays (bracket,).

    Attributes
    ----------
    x
        The roots, or places of the minima.
    f_x
        The function there.
    success
        Whether the tolerances were met.
    bracket, f_bracket
        Ends of the last bracket, and the function at them.
    """

    x: FloatArray
    f_x: FloatArray
    success: BoolArray
    bracket: tuple[FloatArray, ...]
    f_bracket: tuple[FloatArray, ...]


def find_roots(
    f: ElementwiseFunction,
    bracket: tuple[FloatArray, FloatArray],
    *,
    args: tuple[Any, ...] = (),
    tolerances: Mapping[str, float] | None = None,
    maxiter: int | None = None,
) -> Roots:
    """Roots of a function in many brackets at once, by Chandrupatla's method.

    Parameters
    ----------
    f : callable
        The function.
    bracket : two arrays (bracket,)
        Ends at which it has different signs.
    args : tuple of arrays (bracket,)
        Further arguments of the function, which differ between brackets.
    tolerances : mapping of str to float, optional
        ``xatol``, ``xrtol``, ``fatol``, ``frtol``, as SciPy's
        function of the same name takes them.
    maxiter : int, optional
        Largest number of iterations.
    """
    finder: Any = elementwise.find_root
    with np.errstate(all="ignore"):  # of values that are infinite, which have no root near by
        result: Roots = finder(f, bracket, args=args, tolerances=tolerances, maxiter=maxiter)
    return result


def find_minima(
    f: ElementwiseFunction,
    bracket: tuple[FloatArray, FloatArray, FloatArray],
    *,
    args: tuple[Any, ...] = (),
    tolerances: Mapping[str, float] | None = None,
    maxiter: int = 100,
) -> Roots:
    """Minima of a function in many brackets of three points, by Chandrupatla's method.

    The parameters are those of :func:`find_roots`, save that the middle point of a bracket is
    no higher than its ends.
    """
    finder: Any = elementwise.find_minimum
    with np.errstate(all="ignore"):  # of values that are infinite, which have no root near by
        result: Roots = finder(f, bracket, args=args, tolerances=tolerances, maxiter=maxiter)
    return result
