"""Numbers that carry two derivatives: how a formula bends at a point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar


@dataclass(frozen=True)
class Jet:
    """A value with its first and second derivative along one direction.

    The three are numbers of any kind: floats, arrays, symbols.

    Examples
    --------
    >>> x = Jet(2.0, 1.0, 0.0)
    >>> 1 / x
    Jet(value=0.5, slope=-0.25, bend=0.25)
    """

    value: Any
    slope: Any
    bend: Any

    #: Arrays leave arithmetic with jets to the jets.
    __array_ufunc__: ClassVar[None] = None

    def __add__(self, other: Any) -> Jet:
        b = _jet(other)
        return Jet(self.value + b.value, self.slope + b.slope, self.bend + b.bend)

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.slope, -self.bend)

    def __sub__(self, other: Any) -> Jet:
        return self + (-_jet(other))

    def __rsub__(self, other: Any) -> Jet:
        negative = -self
        return negative + _jet(other)

    def __mul__(self, other: Any) -> Jet:
        b = _jet(other)
        bend = self.bend * b.value + 2 * self.slope * b.slope + self.value * b.bend
        return Jet(self.value * b.value, self.slope * b.value + self.value * b.slope, bend)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Jet:
        return self * _jet(other) ** -1

    def __rtruediv__(self, other: Any) -> Jet:
        return _jet(other) * self**-1

    def __pow__(self, n: Any) -> Jet:
        """The power by an exponent without derivatives."""
        return self.mapped(lambda x: (x**n, n * x ** (n - 1), n * (n - 1) * x ** (n - 2)))

    def mapped(self, derivatives: Any) -> Jet:
        """f of this, where ``derivatives(value)`` gives f and its first two derivatives."""
        f, d, dd = derivatives(self.value)
        return Jet(f, d * self.slope, dd * self.slope**2 + d * self.bend)


def _jet(x: Any) -> Jet:
    return x if isinstance(x, Jet) else Jet(x, 0 * x, 0 * x)


@dataclass(frozen=True)
class JetFunctions:
    """The functions of formulas, of jets whose numbers have theirs in `fn`."""

    fn: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self.fn, name)

    def sqrt(self, x: Any) -> Jet:
        """Square root."""

        def derivatives(v: Any) -> tuple[Any, Any, Any]:
            root = self.fn.sqrt(v)
            return root, 1 / (2 * root), -1 / (4 * root * v)

        return _jet(x).mapped(derivatives)

    def exp(self, x: Any) -> Jet:
        """Exponential."""
        return _jet(x).mapped(lambda v: (self.fn.exp(v),) * 3)

    def log(self, x: Any) -> Jet:
        """Natural logarithm."""
        return _jet(x).mapped(lambda v: (self.fn.log(v), 1 / v, -1 / v**2))

    def sin(self, x: Any) -> Jet:
        """Sine."""
        return _jet(x).mapped(lambda v: (self.fn.sin(v), self.fn.cos(v), -self.fn.sin(v)))

    def cos(self, x: Any) -> Jet:
        """Cosine."""
        return _jet(x).mapped(lambda v: (self.fn.cos(v), -self.fn.sin(v), -self.fn.cos(v)))
