"""Bounds of rounding hold against fifty digits."""

from __future__ import annotations

from functools import partial
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from remanent._field import Program
from remanent.analysis.statics.rounding import RoundedDual, RoundedDualFunctions

#: One program that uses every operation once or more: inputs x, p.
PROGRAM = Program(
    ("x", "p"),
    (3.0, 0.1),
    (
        ("mul", 0, 0), ("sub", 4, 2), ("div", 1, 0), ("add", 5, 6), ("neg", 7),
        ("sin", 8), ("cos", 0), ("mul", 9, 10), ("sqrt", 4), ("exp", 12), ("log", 4),
        ("atan", 14), ("mul", 13, 15), ("add", 11, 16), ("mul", 17, 3),
    ),
    (18,),
)  # fmt: skip


class Exact:
    """The functions of mpmath under the names of programs."""

    sqrt, exp, log, sin, cos, atan = mp.sqrt, mp.exp, mp.log, mp.sin, mp.cos, mp.atan


@pytest.mark.parametrize("seed", range(3))
def test_values_and_slopes_are_within_their_bounds(seed: int) -> None:
    """Law: what is computed in doubles differs from the exact value by no more than its bound."""
    rng = np.random.default_rng(seed)
    x, p = rng.uniform(0.3, 3.0, 50), rng.uniform(-2.0, 2.0, 50)
    inputs = [RoundedDual.variable(x, 1.0), RoundedDual.variable(p, 0.0)]
    (found,) = PROGRAM(inputs, functions=RoundedDualFunctions, constant=RoundedDual.constant)
    with mp.workdps(50):

        def exact(y: Any, q: float) -> Any:
            # 0.1 stands for a tenth, as a constant of a program does for what it is the double of
            constant = {3.0: mp.mpf(3), 0.1: mp.mpf(1) / 10}
            return PROGRAM([y, mp.mpf(q)], functions=Exact, constant=constant.__getitem__)[0]

        for k in range(x.size):
            parameter = float(p[k])
            value = exact(mp.mpf(x[k]), parameter)
            slope = mp.diff(partial(exact, q=parameter), mp.mpf(x[k]))
            value_off = abs(mp.mpf(float(found.value.value[k])) - value)
            slope_off = abs(mp.mpf(float(found.slope.value[k])) - slope)
            assert value_off <= found.value.bound[k]
            assert slope_off <= found.slope.bound[k]
            assert found.value.bound[k] < 1e-12 * (1.0 + abs(value))
