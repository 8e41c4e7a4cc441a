"""Second-order automatic differentiation along one direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar


@dataclass(frozen=True)
class SecondOrderDual:
    """A value with its first and second derivative along one direction.

    The three are numbers of any kind: floats, arrays, symbols.

    Examples
    --------
    >>> x = SecondOrderDual(2.0, 1.0, 0.0)
    >>> 1 / x
    SecondOrderDual(value=0.5, first=-0.25, second=0.25)
    """

    value: Any
    first: Any
    second: Any

    #: Arrays leave arithmetic with these numbers to the numbers' own methods.
    __array_ufunc__: ClassVar[None] = None

    def __add__(self, other: Any) -> SecondOrderDual:
        b = _as_dual(other)
        return SecondOrderDual(self.value + b.value, self.first + b.first, self.second + b.second)

    __radd__ = __add__

    def __neg__(self) -> SecondOrderDual:
        return SecondOrderDual(-self.value, -self.first, -self.second)

    def __sub__(self, other: Any) -> SecondOrderDual:
        return self + (-_as_dual(other))

    def __rsub__(self, other: Any) -> SecondOrderDual:
        negative = -self
        return negative + _as_dual(other)

    def __mul__(self, other: Any) -> SecondOrderDual:
        b = _as_dual(other)
        second = self.second * b.value + 2 * self.first * b.first + self.value * b.second
        return SecondOrderDual(
            self.value * b.value, self.first * b.value + self.value * b.first, second
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> SecondOrderDual:
        return self * _as_dual(other) ** -1

    def __rtruediv__(self, other: Any) -> SecondOrderDual:
        return _as_dual(other) * self**-1

    def __pow__(self, n: Any) -> SecondOrderDual:
        """The power by an exponent without derivatives."""
        return self.with_function(lambda x: (x**n, n * x ** (n - 1), n * (n - 1) * x ** (n - 2)))

    def with_function(self, derivatives: Any) -> SecondOrderDual:
        """f of this, where ``derivatives(value)`` gives f and its first two derivatives."""
        f, d, dd = derivatives(self.value)
        return SecondOrderDual(f, d * self.first, dd * self.first**2 + d * self.second)


def _as_dual(x: Any) -> SecondOrderDual:
    return x if isinstance(x, SecondOrderDual) else SecondOrderDual(x, 0 * x, 0 * x)


@dataclass(frozen=True)
class DualFunctions:
    """The functions of formulas, of such numbers, whose parts have their functions in `fn`."""

    fn: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self.fn, name)

    def sqrt(self, x: Any) -> SecondOrderDual:
        """Square root."""

        def derivatives(v: Any) -> tuple[Any, Any, Any]:
            root = self.fn.sqrt(v)
            return root, 1 / (2 * root), -1 / (4 * root * v)

        return _as_dual(x).with_function(derivatives)

    def exp(self, x: Any) -> SecondOrderDual:
        """Exponential."""
        return _as_dual(x).with_function(lambda v: (self.fn.exp(v),) * 3)

    def log(self, x: Any) -> SecondOrderDual:
        """Natural logarithm."""
        return _as_dual(x).with_function(lambda v: (self.fn.log(v), 1 / v, -1 / v**2))

    def sin(self, x: Any) -> SecondOrderDual:
        """Sine."""
        return _as_dual(x).with_function(
            lambda v: (self.fn.sin(v), self.fn.cos(v), -self.fn.sin(v))
        )

    def cos(self, x: Any) -> SecondOrderDual:
        """Cosine."""
        return _as_dual(x).with_function(
            lambda v: (self.fn.cos(v), -self.fn.sin(v), -self.fn.cos(v))
        )
