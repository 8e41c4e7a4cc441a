"""Curves are cut where they leave their bounds."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.curves import Curve, CurveEquations, EquationValues
from remanent.studies.orbits._curve_ends import clip_to_bounds
from tests.unit.analysis.orbits.test_continuation import plane, start


def cut(equations: CurveEquations, box: list[list[float]]) -> tuple[Curve, Curve]:
    """The curve through (0, 0) up to its first points beyond the bounds, and cut at these."""
    lower, upper = np.array(box).T
    settings = ContinuationSettings(lower, upper, np.ones(2), tolerance=1e-12)
    starts = start(equations, np.zeros((1, 2)), settings.scale)
    (curve,) = continue_curves(equations, starts, settings)
    assert curve.end_reasons == ("bounds", "bounds")
    return curve, clip_to_bounds(equations, curve, settings)


def test_a_curve_ends_on_its_bounds() -> None:
    """p = x^3 - x leaves x <= 1.05 at p = 0.107625, and p <= 0.2 at the root next to 0."""
    beyond, found = cut(plane("cubic"), [[-3.0, 1.05], [-2.0, 0.2]])
    roots = np.roots([1.0, 0.0, -1.0, -0.2])
    expected = [[roots[np.abs(roots).argmin()], 0.2], [1.05, 0.107625]]
    ends = found.points.unknown[[0, -1]]
    order = np.argsort(ends[:, 0])
    np.testing.assert_allclose(ends[order], expected, atol=1e-11)
    assert np.array(found.bounded_unknowns)[order].tolist() == [1, 0]
    np.testing.assert_array_equal(found.points.unknown[1:-1], beyond.points.unknown[1:-1])


def test_without_a_point_on_a_bound_a_curve_ends_inside() -> None:
    """x = p, which is not defined on p = 0.5: what lies beyond this bound is left out."""

    def equations(z: FloatArray) -> EquationValues:
        x, p = z.T
        value = np.where(np.abs(p - 0.5) < 1e-9, np.nan, x - p)[:, None]
        derivative = np.tile([1.0, -1.0], (len(z), 1, 1))
        return EquationValues(value, derivative, np.zeros(len(z)), {"d": derivative})

    beyond, found = cut(equations, [[-1.0, 1.0], [-0.25, 0.5]])
    assert beyond.points.unknown[-1, 1] > 0.5
    np.testing.assert_allclose(found.points.unknown[0], [-0.25, -0.25], atol=1e-11)
    np.testing.assert_array_equal(found.points.unknown[1:], beyond.points.unknown[1:-1])
