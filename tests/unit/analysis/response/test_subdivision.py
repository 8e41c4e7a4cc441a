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
    """Of five peaks the one that the table shows third is the highest; all three are looked at."""
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
    nearest = [np.abs(x[:, None] - middle).argmin(axis=1) for x in asked]
    assert {0, 1, 2} <= set(nearest[0])


def test_errors_reach_the_highest_of_ripples_beside_a_jump() -> None:
    """As amplitudes are where motions pass a saddle: ripples ever narrower towards a jump.

    Of two hundred functions the largest value and its place are within the errors but for one in
    fifty; three quarters of them are found to a hundredth of the height of the ripples.
    """
    rng = np.random.default_rng(7)
    count = 200
    jump, height, envelope = (
        rng.uniform(low, high, count) for low, high in ((0.3, 0.7), (0.01, 0.05), (0.5, 3.0))
    )
    ratio, first = rng.uniform(0.2, 0.8, count), 10.0 ** rng.uniform(-6.0, -2.0, count)

    def value(case: IntArray, x: FloatArray) -> FloatArray:
        """Nearer to the jump than `first` there are no more ripples, but a steep rise."""
        beyond = x - jump[case]
        distance = np.maximum(beyond, first[case])
        depth = height[case] * (1.0 - np.abs(np.sin(np.log(distance) / ratio[case])))
        rise = np.minimum(1.0, 0.5 + 0.5 * beyond / first[case])
        return np.where(beyond > 0.0, (1.0 - envelope[case] * distance - depth) * rise, 0.1 * x)

    def measure(case: IntArray, x: FloatArray, level: float, near: IntArray) -> Columns:
        return value(case, x), np.full(x.shape, level), near

    x, cases = np.linspace(0.0, 1.0, 101), np.arange(count)[:, None]
    table = value(cases, np.broadcast_to(x, (count, x.size)))
    found = refine_maxima(
        x, table, np.full(table.shape, 1e-9), np.zeros(table.shape, dtype=np.int64), measure,
        tolerance=1e-9, width=1e-6,
    )  # fmt: skip
    places = jump[:, None] + np.geomspace(first, 0.3, 20_001).T
    exact = value(np.broadcast_to(cases, places.shape), places)
    best = exact.argmax(axis=1)[:, None]
    missing = np.take_along_axis(exact, best, 1)[:, 0] - found.value
    away = np.abs(np.take_along_axis(places, best, 1)[:, 0] - found.position)
    covered = (missing <= found.value_error) & ((away <= found.position_error) | (missing < 1e-6))
    assert covered.mean() >= 0.98
    assert np.mean(missing < 0.01 * height) >= 0.75


@pytest.mark.parametrize("jump", [2.0, 0.4])
def test_a_lone_top_takes_few_points(jump: float) -> None:
    """A smooth top, or one at a jump: at most five rounds of sixteen points."""
    asked: list[int] = []

    def measure(_case: IntArray, x: FloatArray, level: float, near: IntArray) -> Columns:
        asked.append(x.size)
        smooth = np.exp(-((x - 0.4321) ** 2) / 0.02)
        return np.where(x < jump, smooth, 0.0), np.full(x.shape, level), near

    x = np.linspace(0.0, 1.0, 101)
    values, errors, near = measure(np.zeros(101, dtype=int), x, 1e-9, np.zeros(101, dtype=int))
    asked.clear()
    found = refine_maxima(
        x, values[None], errors[None], near[None], measure, tolerance=1e-9, width=1e-6
    )
    assert found.position_error[0] <= 1e-6
    assert sum(asked) <= 5 * 16


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
        return -np.abs(x - 0.52), np.full(x.shape, level), needed(x)

    x = np.linspace(0.0, 1.0, 11)
    values, errors = -np.abs(x - 0.52)[None], np.full((1, 11), 1e-6)
    refine_maxima(x, values, errors, needed(x)[None], measure, tolerance=1e-6, width=1e-7)
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


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
@pytest.mark.parametrize("share", [0.5, 1e-3, 0.0])
def test_of_two_maxima_that_errors_make_equal_the_larger_is_found(
    tolerance: float, share: float, sign: float
) -> None:
    """Computed with smaller errors; where these do not tell either, the error reaches both."""
    places = np.array([0.3137, 0.7211])
    more = share * tolerance

    def measure(_case: IntArray, x: FloatArray, level: float, near: IntArray) -> Columns:
        values = np.maximum(
            1.0 - 5.0 * (x - places[0]) ** 2, 1.0 + more - 50.0 * (x - places[1]) ** 2
        )
        return values + 0.6 * sign * level * np.sign(x - 0.5), np.full(x.shape, level), near

    x = np.linspace(0.0, 1.0, 201)
    values, errors, near = measure(NONE, x, tolerance, np.zeros(201, dtype=int))
    found = refine_maxima(
        x, values[None], errors[None], near[None], measure, tolerance=tolerance, width=1e-4
    )
    away = np.abs(found.position[0] - places)
    assert away[1] <= found.position_error[0]
    assert abs(found.value[0] - 1.0 - more) <= found.value_error[0]
    if more:
        assert found.position_error[0] <= 1e-4
    else:
        assert (away <= found.position_error[0]).all()


@pytest.mark.parametrize(
    ("top", "wide", "unknown"),
    [(0.7, 0.03, (0.655, 0.745)), (0.05, 0.04, (-1.0, 0.11)), (0.95, 0.04, (0.88, 2.0))],
)
def test_errors_reach_a_top_among_unknown_values(
    top: float, wide: float, unknown: tuple[float, float]
) -> None:
    """The values beside the unknown ones rise towards them, inside the table or at its ends."""

    def value(x: FloatArray) -> FloatArray:
        return 1.0 - 2.0 * (x - 0.4137) ** 2 + 1.2 * np.exp(-(((x - top) / wide) ** 2))

    def measure(_case: IntArray, x: FloatArray, level: float, near: IntArray) -> Columns:
        is_unknown = (unknown[0] < x) & (x < unknown[1])
        return np.where(is_unknown, np.nan, value(x)), np.full(x.shape, level), near

    x = np.linspace(0.0, 1.0, 201)
    values, errors, near = measure(NONE, x, 1e-9, np.zeros(201, dtype=int))
    found = refine_maxima(
        x, values[None], errors[None], near[None], measure, tolerance=1e-9, width=1e-6
    )
    fine = np.linspace(0.0, 1.0, 100_001)
    best = value(fine).argmax()
    assert abs(found.position[0] - fine[best]) <= found.position_error[0]
    assert value(fine)[best] - found.value[0] <= found.value_error[0]
