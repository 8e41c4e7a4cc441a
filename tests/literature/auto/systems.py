"""The equations once more, for the reference: rates per drive period, phase in [0, 1]."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import heyoka as hy


def actuator(x: Any, v: Any, s: Any, par: Sequence[Any]) -> tuple[Any, Any]:
    """Equation (16) under (b sin omega tau)^2; parameters omega, theta, S, b, c, eta."""
    omega, theta, prestress, b, c, eta = par
    period = hy.pi / omega
    load = b * hy.sin(hy.pi * s)
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + load * load * x4 + eta * v * x7
    return period * v, period * (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)


def oscillator(x: Any, v: Any, s: Any, par: Sequence[Any]) -> tuple[Any, Any]:
    """The forced oscillator of oscillator.f90; omega, d, g, a, e, k, F."""
    omega, d, g, a, e, k, strength = par
    period = 2.0 * hy.pi / omega
    p = hy.cos(2.0 * hy.pi * s)
    force = strength * p - (d + g * x * x) * v - (a + e * p) * x - k * x * x * x
    return period * v, period * force
