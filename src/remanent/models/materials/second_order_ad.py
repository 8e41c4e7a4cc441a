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
    SecondOrderDual(value=0.5, first_derivative=-0.25, second_derivative=0.25)
    """

    value: Any
    first_derivative: Any
    second_derivative: Any

    #: Arrays leave arithmetic with these numbers to the numbers' own methods.
    __array_ufunc__: ClassVar[None] = None

    def __add__(self, other: Any) -> SecondOrderDual:
        b = _as_dual(other)
        return SecondOrderDual(
            self.value + b.value,
            self.first_derivative + b.first_derivative,
            self.second_derivative + b.second_derivative,
        )

    __radd__ = __add__

    def __neg__(self) -> SecondOrderDual:
        return SecondOrderDual(-self.value, -self.first_derivative, -self.second_derivative)

    def __sub__(self, other: Any) -> SecondOrderDual:
        return self + (-_as_dual(other))

    def __rsub__(self, other: Any) -> SecondOrderDual:
        negative = -self
        return negative + _as_dual(other)

    def __mul__(self, other: Any) -> SecondOrderDual:
        b = _as_dual(other)
        second = (
            self.second_derivative * b.value
            + 2 * self.first_derivative * b.first_derivative
            + self.value * b.second_derivative
        )
        return SecondOrderDual(
            self.value * b.value,
            self.first_derivative * b.value + self.value * b.first_derivative,
            second,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> SecondOrderDual:
        return self * _as_dual(other) ** -1

    def __rtruediv__(self, other: Any) -> SecondOrderDual:
        return _as_dual(other) * self**-1

    def __pow__(self, n: Any) -> SecondOrderDual:
        """The power by an exponent without derivatives."""

        def derivatives(x: Any) -> tuple[Any, Any, Any]:
            # A vanishing factor stands for the whole derivative, also where x is 0.
            first = 0 * x if _is_integer(n, 0) else n * x ** (n - 1)
            flat = _is_integer(n, 0) or _is_integer(n, 1)
            return x**n, first, 0 * x if flat else n * (n - 1) * x ** (n - 2)

        return self.apply_function(derivatives)

    def apply_function(self, derivatives: Any) -> SecondOrderDual:
        """f of this, where ``derivatives(value)`` gives f and its first two derivatives."""
        f, d, dd = derivatives(self.value)
        return SecondOrderDual(
            f, d * self.first_derivative, dd * self.first_derivative**2 + d * self.second_derivative
        )


def _is_integer(n: Any, value: int) -> bool:
    """Whether an exponent is this integer as it is written, not by its value."""
    return isinstance(n, int) and n == value


def _as_dual(x: Any) -> SecondOrderDual:
    return x if isinstance(x, SecondOrderDual) else SecondOrderDual(x, 0 * x, 0 * x)


@dataclass(frozen=True)
class DualFunctions:
    """The functions of formulas, of such numbers; `part_functions` has those of their parts."""

    part_functions: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self.part_functions, name)

    def sqrt(self, x: Any) -> SecondOrderDual:
        """Square root."""

        def derivatives(v: Any) -> tuple[Any, Any, Any]:
            root = self.part_functions.sqrt(v)
            return root, 1 / (2 * root), -1 / (4 * root * v)

        return _as_dual(x).apply_function(derivatives)

    def exp(self, x: Any) -> SecondOrderDual:
        """Exponential."""
        return _as_dual(x).apply_function(lambda v: (self.part_functions.exp(v),) * 3)

    def log(self, x: Any) -> SecondOrderDual:
        """Natural logarithm."""
        return _as_dual(x).apply_function(lambda v: (self.part_functions.log(v), 1 / v, -1 / v**2))

    def sin(self, x: Any) -> SecondOrderDual:
        """Sine."""
        return _as_dual(x).apply_function(
            lambda v: (
                self.part_functions.sin(v),
                self.part_functions.cos(v),
                -self.part_functions.sin(v),
            )
        )

    def cos(self, x: Any) -> SecondOrderDual:
        """Cosine."""
        return _as_dual(x).apply_function(
            lambda v: (
                self.part_functions.cos(v),
                -self.part_functions.sin(v),
                -self.part_functions.cos(v),
            )
        )
