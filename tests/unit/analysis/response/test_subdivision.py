"""Largest values of functions that jump."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._typing import FloatArray, IntArray
from remanent.analysis.response.subdivision import refine_maxima

#: Values, errors and resolutions.
Columns = tuple[FloatArray, FloatArray, IntArray]
#: Resolutions beside points that are not told.
NONE = np.zeros(0, dtype=np.int64)


def exact(values: FloatArray) -> Columns:
    """Without errors, and computed alike."""
    return values, np.zeros(values.shape), np.zeros(values.shape, dtype=np.int64)


@pytest.mark.parametrize("width", [1e-3, 1e-9])
def test_largest_of_a_function_that_jumps(width: float) -> None:
    """exp(-|x - a|) for x below a, 0 above: the maximum sits at the jump."""
    jump = np.array([0.3217, 0.7071])

    def measure(case: IntArray, x: FloatArray, _: float, _near: IntArray) -> Columns:
        return exact(np.where(x < jump[case], np.exp(x - jump[case]), 0.0))

    x = np.linspace(0.0, 1.0, 11)
    table = np.stack([measure(np.full(11, k), x, 1e-9, NONE)[0] for k in range(2)])
    found = refine_maxima(x, *exact(table), measure, tolerance=1e-9, width=width)
    assert (found.position_error <= width).all()
    assert found.is_inside.all()
    assert (np.abs(found.position - jump) <= found.position_error).all()
    assert (np.abs(found.value - 1.0) <= found.value_error).all()


def test_largest_is_never_below_the_table() -> None:
    """What was tabulated is not forgotten, and NaN is never the largest."""
    x = np.linspace(0.0, 1.0, 5)
    table = np.array([[0.1, np.nan, 0.9, np.nan, 0.2], [np.nan] * 5])

    def unknown(case: IntArray, at: FloatArray, _: float, _near: IntArray) -> Columns:
        values, errors, resolutions = exact(np.full(np.broadcast(case, at).shape, np.nan))
        return values, errors + np.nan, resolutions

    found = refine_maxima(x, *exact(table), unknown, tolerance=1e-9, width=1e-3)
    assert (found.position[0], found.value[0]) == (0.5, 0.9)
    assert found.position_error[0] == 0.5
    assert np.isnan(found.value[1])


def test_the_highest_of_three_peaks_is_found_where_the_table_hides_it() -> None:
    """Of five peaks the one that the table shows third is the highest; one less each time."""
    middle = np.array([0.10, 0.30, 0.525, 0.70, 0.90])
    height = np.array([1.00, 0.99, 1.10, 0.50, 0.40])
    asked: list[FloatArray] = []

    def measure(_case: IntArray, x: FloatArray, _: float, _near: IntArray) -> Columns:
        asked.append(x)
        return exact((height * np.exp(-((40.0 * (x[:, None] - middle)) ** 2) / 5.0)).max(1))

    x = np.linspace(0.0, 1.0, 21)
    table = measure(np.zeros(21, dtype=np.int64), x, 1e-9, NONE)[0][None]
    asked.clear()
    found = refine_maxima(x, *exact(table), measure, tolerance=1e-9, width=1e-4)
    assert abs(found.position[0] - 0.525) <= found.position_error[0] <= 1e-4
    peaks = [np.unique(np.abs(x[:, None] - middle).argmin(axis=1)).size for x in asked]
    assert peaks == [3, 2, *[1] * (len(peaks) - 2)]


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("width", [1e-3, 1e-6, 1e-9])
def test_errors_cover_a_smooth_top_that_noise_hides(tolerance: float, width: float) -> None:
    """A parabola with errors of the tolerance, of any sign: its top is within its error.

    No bracket is narrower than the errors let tell, and smaller errors are asked for where they
    help.
    """
    tops = np.linspace(0.31, 0.69, 24)
    asked: list[float] = []

    def measure(case: IntArray, x: FloatArray, level: float, near: IntArray) -> Columns:
        asked.append(level)
        noise = level * np.sin(1e9 * x + 1e3 * case)
        return 1.0 - 5.0 * (x - tops[case]) ** 2 + noise, np.full(x.shape, level), near

    x = np.linspace(0.0, 1.0, 21)
    rows = [measure(np.full(21, k), x, tolerance, np.zeros(21, dtype=int)) for k in range(24)]
    values, errors, near = (np.stack(column) for column in zip(*rows, strict=True))
    found = refine_maxima(x, values, errors, near, measure, tolerance=tolerance, width=width)
    assert (np.abs(found.position - tops) <= found.position_error).all()
    assert (np.abs(found.value - 1.0) <= found.value_error).all()
    assert (found.position_error <= 30.0 * max(width, np.sqrt(min(asked) / 5.0))).all()


def test_no_maximum_inside() -> None:
    """A function that grows to an end of the table, a constant, and a single point have none."""
    x = np.linspace(0.0, 1.0, 9)

    def measure(case: IntArray, at: FloatArray, level: float, near: IntArray) -> Columns:
        return np.where(case == 0, at, 0.25), np.full(at.shape, level), near

    table = np.stack([x, np.full(9, 0.25)])
    values, errors, resolutions = table, np.full(table.shape, 1e-9), exact(table)[2]
    found = refine_maxima(x, values, errors, resolutions, measure, tolerance=1e-9, width=1e-6)
    assert not found.is_inside.any()
    assert found.is_at_end[0]
    alone = refine_maxima(
        x[:1], values[:, :1], errors[:, :1], resolutions[:, :1], measure, tolerance=1e-9,
        width=1e-6,
    )  # fmt: skip
    assert not alone.is_inside.any()


def test_a_case_that_takes_too_much_is_cut_short_alone() -> None:
    """No point beyond its effort is computed; its bracket holds the maximum, and others go on."""
    asked: list[tuple[IntArray, FloatArray]] = []

    def measure(case: IntArray, x: FloatArray, _: float, _near: IntArray) -> Columns:
        asked.append((case, x))
        return exact(-np.abs(x - 0.3217))

    def effort(case: IntArray, x: FloatArray) -> FloatArray:
        return np.where(case == 0, 1.0, 1e6) * np.ones(x.shape)

    x = np.linspace(0.0, 1.0, 11)
    table = np.tile(-np.abs(x - 0.3217), (2, 1))
    found = refine_maxima(
        x, *exact(table), measure, tolerance=1e-9, width=1e-6, effort=effort, max_effort=1e6
    )
    assert found.is_cut_short.tolist() == [False, True]
    assert all((case == 0).all() for case, _ in asked)
    assert found.position_error[0] <= 1e-6
    assert abs(found.position[1] - 0.3217) <= found.position_error[1]
    alone = refine_maxima(x, *exact(table[:1]), measure, tolerance=1e-9, width=1e-6)
    assert alone.position[0] == found.position[0]


def test_points_are_told_what_their_neighbours_needed() -> None:
    """The larger resolution of the two; at a smaller tolerance none is known, but then it is."""
    told: list[tuple[float, FloatArray, IntArray]] = []

    def needed(x: FloatArray) -> IntArray:
        return np.asarray(np.rint(100.0 * x), dtype=np.int64)

    def measure(_case: IntArray, x: FloatArray, level: float, near: IntArray) -> Columns:
        told.append((level, x, near))
        return -((x - 0.52) ** 2), np.full(x.shape, level), needed(x)

    x = np.linspace(0.0, 1.0, 11)
    values, errors = -((x - 0.52) ** 2)[None], np.full((1, 11), 1e-6)
    refine_maxima(x, values, errors, needed(x)[None], measure, tolerance=1e-6, width=1e-5)
    seen, before = x, 1e-6
    for level, at, near in told:
        if level < before:
            np.testing.assert_array_equal(near, 0)
            seen, before = at, level
            continue
        np.testing.assert_array_equal(near, needed(seen[np.searchsorted(seen, at)]))
        seen = np.sort(np.concatenate([seen, at]))
    assert len({level for level, *_ in told}) > 1
    assert len(told) > len({level for level, *_ in told}) + 1
