"""Runge-Kutta coefficients that check themselves when they are built.

A step is written for numbers of any kind: floats, NumPy arrays, mpmath numbers
(fifty digits, for the order tests), lanes of a kernel that is being compiled.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

#: ``rates(stage_node, state)`` with `stage_node` an index into ``nodes``.
RatesAtNode = Callable[[int, list[Any]], list[Any]]
#: Factor between the error that two solutions show and the one reported.
_SAFETY_FACTOR = 4.0


@dataclass(frozen=True)
class RungeKuttaMethod:
    """An explicit Runge-Kutta method.

    Attributes
    ----------
    name
        Part of the fingerprint of every kernel made with the method.
    order
        Order of the global error.
    nodes
        The distinct abscissae in [0, 1] at which the load is needed, ascending.
    stage_node_indices
        For each stage the index of its abscissa in `nodes`.
    stage_weights
        For each stage the coefficients of the earlier stages that are not zero.
    final_weights
        Coefficients of the stages in the result.
    """

    name: str
    order: int
    nodes: tuple[Any, ...]
    stage_node_indices: tuple[int, ...]
    stage_weights: tuple[Mapping[int, Any], ...]
    final_weights: Mapping[int, Any]

    def __post_init__(self) -> None:
        tolerance = 1e-13
        for stage, row in enumerate(self.stage_weights):
            if any(j >= stage for j in row):
                raise ValueError(f"{self.name}: stage {stage} is not explicit")
            if abs(sum(row.values()) - self.nodes[self.stage_node_indices[stage]]) > tolerance:
                raise ValueError(f"{self.name}: row {stage} does not add up to its node")
        for power in range(self.order):
            moment = sum(
                b * self.nodes[self.stage_node_indices[i]] ** power
                for i, b in self.final_weights.items()
            )
            if abs(moment - 1 / type(moment)(power + 1)) > tolerance:
                raise ValueError(f"{self.name}: quadrature condition {power + 1} fails")

    @property
    def load_node_indices(self) -> tuple[int, ...]:
        """Nodes at which the load is needed in every step: all."""
        return tuple(range(len(self.nodes)))

    @property
    def evaluations_per_step(self) -> int:
        """Of the rates, in every step."""
        return len(self.stage_node_indices)

    @property
    def order_assumed_by_error_estimate(self) -> int:
        """Order that the error estimate counts on: two less, as a reserve.

        Where steps are long, and where errors of several pieces of time cancel, halving
        the step gains less than the order promises.  Measured by ``benchmarks.coverage``:
        a reserve of none covers 99.1 % of trajectories (97 % at tolerances above 1e-5),
        of two 99.97 %.
        """
        return self.order - 2

    @property
    def error_per_solution_difference(self) -> float:
        """Error that is reported, over the difference of solutions with steps h and 2h."""
        return _SAFETY_FACTOR / (2.0**self.order_assumed_by_error_estimate - 1.0)

    @property
    def rate_steps_at_extremes(self) -> float:
        """Steps by which a difference of rates counts in the error of an extremum."""
        return 1.0

    @property
    def recent_share_at_extremes(self) -> float:
        """Share of recent differences of two solutions in the error of an extremum: none."""
        return 0.0

    @property
    def has_compensated_sum(self) -> bool:
        """Whether what rounding cuts off from the state is carried on."""
        return True

    @property
    def coarse_solution_lost_bits(self) -> int:
        """Digits that the coarser solution does without: two more than its counted order asks.

        Rounding of phases and coefficients, which both solutions share, is thereby
        allowed for.
        """
        return self.order_assumed_by_error_estimate + 2

    def step(self, rates: RatesAtNode, y: Sequence[Any], h: Any) -> list[Any]:
        """Advance the state `y` by one step of length `h`."""
        return [a + b for a, b in zip(y, self.increment(rates, y, h), strict=True)]

    def increment(self, rates: RatesAtNode, y: Sequence[Any], h: Any) -> list[Any]:
        """What one step of length `h` adds to the state `y`."""
        return self.increment_from_slopes(self.stage_slopes(rates, y, h), h)

    def stage_slopes(self, rates: RatesAtNode, y: Sequence[Any], h: Any) -> list[list[Any]]:
        """The rates at every stage of a step of length `h` from the state `y`."""
        slopes: list[list[Any]] = []
        for node, row in zip(self.stage_node_indices, self.stage_weights, strict=True):
            slopes.append(rates(node, _stage_state(y, h, row, slopes)))
        return slopes

    def increment_from_slopes(self, slopes: list[list[Any]], h: Any) -> list[Any]:
        """What a step of length `h` with these slopes adds to the state."""
        return [
            h * _weighted_slope_sum(self.final_weights, slopes, i) for i in range(len(slopes[0]))
        ]


def compensated_sum(
    y: Sequence[Any], change: Sequence[Any], compensation: Sequence[Any]
) -> tuple[list[Any], list[Any]]:
    """Add `change` to `y` with what earlier roundings cut off; return the sum and what it cuts off.

    References
    ----------
    W. Kahan, Comm. ACM 8 (1965) 40.
    """
    moved, cut = [], []
    for a, b, r in zip(y, change, compensation, strict=True):
        increment = b + r
        moved.append(a + increment)
        cut.append(increment - (moved[-1] - a))
    return moved, cut


def _stage_state(
    y: Sequence[Any], h: Any, weights: Mapping[int, Any], slopes: list[list[Any]]
) -> list[Any]:
    if not weights:
        return list(y)
    return [y_i + h * _weighted_slope_sum(weights, slopes, i) for i, y_i in enumerate(y)]


def _weighted_slope_sum(weights: Mapping[int, Any], slopes: list[list[Any]], i: int) -> Any:
    terms = iter(weights.items())
    j, weight = next(terms)
    total = slopes[j][i] * weight
    for j, weight in terms:
        total = total + slopes[j][i] * weight
    return total


def cooper_verner_8(sqrt: Callable[[Any], Any], number: Callable[[int], Any]) -> RungeKuttaMethod:
    """Eleven stages, order 8, closed form in the square root of 21.

    Parameters
    ----------
    sqrt, number
        Square root and constructor of the numbers wanted (``math.sqrt`` and
        ``float``, or ``mpmath.sqrt`` and ``mpmath.mpf``).

    References
    ----------
    G. J. Cooper and J. H. Verner, SIAM J. Numer. Anal. 9 (1972) 389-405.
    """
    s, n = sqrt(number(21)), number
    return RungeKuttaMethod(
        name="cooper-verner-8",
        order=8,
        nodes=(n(0), (7 - s) / 14, n(1) / 2, (7 + s) / 14, n(1)),
        stage_node_indices=(0, 2, 2, 3, 3, 2, 1, 1, 2, 3, 4),
        stage_weights=(
            {},
            {0: n(1) / 2},
            {0: n(1) / 4, 1: n(1) / 4},
            {0: n(1) / 7, 1: (-7 - 3 * s) / 98, 2: (21 + 5 * s) / 49},
            {0: (11 + s) / 84, 2: (18 + 4 * s) / 63, 3: (21 - s) / 252},
            {0: (5 + s) / 48, 2: (9 + s) / 36, 3: (14 * s - 231) / 360, 4: (63 - 7 * s) / 80},
            {
                0: (10 - s) / 42,
                2: (92 * s - 432) / 315,
                3: (633 - 145 * s) / 90,
                4: (115 * s - 504) / 70,
                5: (63 - 13 * s) / 35,
            },
            {0: n(1) / 14, 4: (14 - 3 * s) / 126, 5: (13 - 3 * s) / 63, 6: n(1) / 9},
            {
                0: n(1) / 32,
                4: (91 - 21 * s) / 576,
                5: n(11) / 72,
                6: -(385 + 75 * s) / 1152,
                7: (63 + 13 * s) / 128,
            },
            {
                0: n(1) / 14,
                4: n(1) / 9,
                5: -(733 + 147 * s) / 2205,
                6: (515 + 111 * s) / 504,
                7: -(51 + 11 * s) / 56,
                8: (132 + 28 * s) / 245,
            },
            {
                4: (7 * s - 42) / 18,
                5: (28 * s - 18) / 45,
                6: -(273 + 53 * s) / 72,
                7: (301 + 53 * s) / 72,
                8: (28 - 28 * s) / 45,
                9: (49 - 7 * s) / 18,
            },
        ),
        final_weights={0: n(1) / 20, 7: n(49) / 180, 8: n(16) / 45, 9: n(49) / 180, 10: n(1) / 20},
    )


@cache
def default_method() -> RungeKuttaMethod:
    """The method of every verb, in double precision."""
    import math

    method = cooper_verner_8(math.sqrt, float)
    frozen = tuple(MappingProxyType(dict(row)) for row in method.stage_weights)
    return RungeKuttaMethod(
        method.name,
        method.order,
        method.nodes,
        method.stage_node_indices,
        frozen,
        MappingProxyType(dict(method.final_weights)),
    )
