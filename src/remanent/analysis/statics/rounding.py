"""Bounds of the rounding in straight-line code, and of that in its derivative."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from remanent._typing import FloatArray

#: Largest relative error of one rounded operation.
_UNIT_ROUNDOFF = 0.5 * float(np.finfo(float).eps)
#: Roundings in a function of the mathematical library.
_FUNCTION_ROUNDINGS = 2.0
#: The bound of numbers that are exact.
_EXACT = 0.0


@dataclass(frozen=True)
class Rounded:
    """Numbers as computed, with bounds of how far rounding took each from the exact one.

    Every operation adds half a unit of its last digit and hands on what its operands bring
    (running error analysis: N. J. Higham, Accuracy and Stability of Numerical Algorithms,
    2nd edition (SIAM, 2002), section 3.3).

    Attributes
    ----------
    value, bound : array (point,)
        Bounds of exact numbers are one and the same 0, with which nothing is computed.
    """

    value: Any
    bound: Any = _EXACT

    @classmethod
    def constant(cls, number: float) -> Rounded:
        """A constant of a program: exact if it is a whole number."""
        is_exact = number == round(number)
        return cls(number, _EXACT if is_exact else _UNIT_ROUNDOFF * abs(number))

    def _with_rounding(self, value: Any, bound: Any, roundings: float = 1.0) -> Rounded:
        return Rounded(value, _sum(bound, roundings * _UNIT_ROUNDOFF * abs(value)))

    def __add__(self, other: Rounded) -> Rounded:
        if self is ZERO:
            return other
        if other is ZERO:
            return self
        return self._with_rounding(self.value + other.value, _sum(self.bound, other.bound))

    def __sub__(self, other: Rounded) -> Rounded:
        if self is ZERO:
            return -other
        if other is ZERO:
            return self
        return self._with_rounding(self.value - other.value, _sum(self.bound, other.bound))

    def __neg__(self) -> Rounded:
        return self if self is ZERO else Rounded(-self.value, self.bound)

    def __mul__(self, other: Rounded) -> Rounded:
        if self is ZERO or other is ZERO:
            return ZERO
        size = abs(other.value) if other.bound is _EXACT else abs(other.value) + other.bound
        bound = _EXACT if self.bound is _EXACT else self.bound * size
        if other.bound is not _EXACT:
            bound = _sum(bound, abs(self.value) * other.bound)
        return self._with_rounding(self.value * other.value, bound)

    def __truediv__(self, other: Rounded) -> Rounded:
        if self is ZERO:
            return ZERO
        value = self.value / other.value
        if other.bound is not _EXACT:
            bound = _sum(self.bound, abs(value) * other.bound)
            least = np.maximum(abs(other.value) - other.bound, 0.0)
            return self._with_rounding(value, bound / least)
        bound = _EXACT if self.bound is _EXACT else self.bound / abs(other.value)
        return self._with_rounding(value, bound)

    def sqrt(self) -> Rounded:
        """Square root."""
        value = np.sqrt(self.value)
        return self._with_rounding(value, _over(self.bound, value))

    def exp(self) -> Rounded:
        """Exponential."""
        value = np.exp(self.value)
        return self._with_rounding(value, value * np.expm1(self.bound), _FUNCTION_ROUNDINGS)

    def log(self) -> Rounded:
        """Natural logarithm."""
        bound = _over(self.bound, abs(self.value) - self.bound)
        return self._with_rounding(np.log(self.value), bound, _FUNCTION_ROUNDINGS)

    def sin(self) -> Rounded:
        """Sine."""
        return self._with_rounding(np.sin(self.value), self.bound, _FUNCTION_ROUNDINGS)

    def cos(self) -> Rounded:
        """Cosine."""
        return self._with_rounding(np.cos(self.value), self.bound, _FUNCTION_ROUNDINGS)

    def atan(self) -> Rounded:
        """Inverse tangent."""
        return self._with_rounding(np.arctan(self.value), self.bound, _FUNCTION_ROUNDINGS)


#: The slope of what does not change, with which nothing is computed.
ZERO = Rounded(0.0)


@dataclass(frozen=True)
class RoundedDual:
    """A number and its derivative along one direction, both with bounds of their rounding.

    Attributes
    ----------
    value, slope : Rounded
    """

    value: Rounded
    slope: Rounded = ZERO

    @classmethod
    def constant(cls, number: float) -> RoundedDual:
        """A constant of a program, which does not change."""
        return cls(Rounded.constant(number))

    @classmethod
    def variable(cls, value: FloatArray, slope: float | FloatArray) -> RoundedDual:
        """An exact number that changes as fast as `slope` says."""
        return cls(Rounded(value), ZERO if np.ndim(slope) == 0 and slope == 0 else Rounded(slope))

    def __add__(self, other: RoundedDual) -> RoundedDual:
        return RoundedDual(self.value + other.value, self.slope + other.slope)

    def __sub__(self, other: RoundedDual) -> RoundedDual:
        return RoundedDual(self.value - other.value, self.slope - other.slope)

    def __neg__(self) -> RoundedDual:
        return RoundedDual(-self.value, -self.slope)

    def __mul__(self, other: RoundedDual) -> RoundedDual:
        slope = self.slope * other.value + self.value * other.slope
        return RoundedDual(self.value * other.value, slope)

    def __truediv__(self, other: RoundedDual) -> RoundedDual:
        value = self.value / other.value
        return RoundedDual(value, (self.slope - value * other.slope) / other.value)


class RoundedDualFunctions:
    """Functions of such numbers, under the names that programs look them up by."""

    @staticmethod
    def sqrt(x: RoundedDual) -> RoundedDual:
        """Square root."""
        root = x.value.sqrt()
        return RoundedDual(root, x.slope / (root + root))

    @staticmethod
    def exp(x: RoundedDual) -> RoundedDual:
        """Exponential."""
        value = x.value.exp()
        return RoundedDual(value, x.slope * value)

    @staticmethod
    def log(x: RoundedDual) -> RoundedDual:
        """Natural logarithm."""
        return RoundedDual(x.value.log(), x.slope / x.value)

    @staticmethod
    def sin(x: RoundedDual) -> RoundedDual:
        """Sine."""
        return RoundedDual(x.value.sin(), x.slope * x.value.cos())

    @staticmethod
    def cos(x: RoundedDual) -> RoundedDual:
        """Cosine."""
        return RoundedDual(x.value.cos(), -(x.slope * x.value.sin()))

    @staticmethod
    def atan(x: RoundedDual) -> RoundedDual:
        """Inverse tangent."""
        return RoundedDual(x.value.atan(), x.slope / (Rounded(1.0) + x.value * x.value))


def _sum(first: Any, second: Any) -> Any:
    """A sum of bounds."""
    return second if first is _EXACT else first if second is _EXACT else first + second


def _over(numerator: Any, denominator: Any) -> Any:
    """A quotient of bounds that is 0 where nothing is to be divided."""
    if numerator is _EXACT:
        return _EXACT
    with np.errstate(all="ignore"):
        return np.where(np.asarray(numerator) == 0.0, 0.0, numerator / np.maximum(denominator, 0.0))
