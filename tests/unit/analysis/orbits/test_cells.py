"""Zeros of functions that are known in closed form are all found, by cells."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Cells, Sample
from remanent.analysis.orbits.cells import (
    _UNKNOWN,
    CellSearchOutcome,
    _with_curvature_of_neighbours,
    zeros_by_cells,
)
from remanent.analysis.orbits.flat_cells import may_be_flat

#: A function of x and y as a complex one of z = x + i y, and its derivative.
Holomorphic = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


def zeros(
    of: Holomorphic, *, flatness: float = 1e-8, first_cells: tuple[int, int] = (10, 9)
) -> CellSearchOutcome:
    def sample(points: FloatArray, _: float, __: IntArray | None) -> Sample:
        value, slope = of(points[:, 0] + 1j * points[:, 1])
        derivative = np.stack([slope, 1j * slope], axis=1)
        return Sample(
            np.column_stack([value.real, value.imag]),
            np.stack([derivative.real, derivative.imag], axis=1),
            np.full(len(points), 1e-15),
            np.ones(len(points), dtype=np.int64),
        )

    columns, rows = first_cells
    edges = [np.linspace(-2.0, 2.0, columns + 1), np.linspace(-2.1, 2.0, rows + 1)]
    return zeros_by_cells(sample, edges, flatness=flatness, max_effort=30_000)


@pytest.mark.parametrize("degree", [1, 2, 3, 7])
def test_roots_of_unity_are_all_found(degree: int) -> None:
    """z^n = 1 has n roots on the unit circle, and each is near a start of Newton's method."""
    found = zeros(lambda z: (z**degree - 1.0, degree * z ** (degree - 1)))
    starts = found.starts[:, 0] + 1j * found.starts[:, 1]
    roots = np.exp(2j * np.pi * np.arange(degree) / degree)
    assert not len(found.unresolved)
    assert np.abs(starts - roots[:, None]).min(axis=1).max() < 0.05


@pytest.mark.parametrize("first_cells", [(1, 1), (1, 9), (10, 1)])
def test_zeros_are_found_where_no_neighbour_tells_curvature(first_cells: tuple[int, int]) -> None:
    """z^4 = 1 from cells as wide or as high as the box, which have no neighbour on that side."""
    found = zeros(lambda z: (z**4 - 1.0, 4.0 * z**3), first_cells=first_cells)
    starts = found.starts[:, 0] + 1j * found.starts[:, 1]
    assert not len(found.unresolved)
    assert np.abs(starts - 1j ** np.arange(4)[:, None]).min(axis=1).max() < 0.05


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5])
def test_the_error_that_is_asked_for_is_a_small_share_of_cells(width: float) -> None:
    """Zeros of cos(30 x/width): in every round the error is below a tenth of half a cell."""
    frequency, shares = 30.0 / width, []

    def cosine(points: FloatArray, tolerance: float, _: IntArray | None) -> Sample:
        half_width = 0.5 * np.diff(np.sort(points[:, 0])).min()
        shares.append(tolerance / half_width)
        ones = np.ones(len(points))
        slope = -frequency * np.sin(frequency * points)
        return Sample(
            np.cos(frequency * points), slope[:, :, None], 1e-15 * ones, ones.astype(np.int64)
        )

    edges = [np.linspace(0.0, width, 11)]
    found = zeros_by_cells(cosine, edges, flatness=0.0, max_effort=1e5)
    exact = np.pi * (np.arange(9) + 0.5) / frequency  # up to 8.5 pi < 30
    assert np.abs(found.starts - exact).min(axis=0).max() < 1e-2 * width
    assert len(shares) > 1
    assert max(shares) < 0.1


@pytest.mark.parametrize("apart", [1e-1, 1e-3, 1e-5])
def test_a_pair_of_zeros_is_found_however_near(apart: float) -> None:
    """z^2 = (apart/2)^2: two zeros, and a derivative that vanishes between them."""
    found = zeros(lambda z: (z**2 - apart**2 / 4.0, 2.0 * z), flatness=1e-16)
    starts = found.starts[:, 0]
    assert not len(found.unresolved)
    assert starts.min() < 0.0 < starts.max()


def test_a_function_without_zeros_has_none() -> None:
    """The exponential function vanishes nowhere."""
    found = zeros(lambda z: (np.exp(z), np.exp(z)))
    assert not len(found.starts) + len(found.unresolved) + len(found.flat)


def test_parallel_lines_are_excluded_at_once() -> None:
    """x = y and x - y = 1e-3: their difference is 1e-3 everywhere, which one look at a cell shows.

    Each component alone vanishes in many cells.
    """

    def lines(points: FloatArray, _: float, __: IntArray | None) -> Sample:
        difference = points[:, 0] - points[:, 1]
        slope = np.tile([[1.0, -1.0], [1.0, -1.0]], (len(points), 1, 1))
        value = np.column_stack([difference, difference - 1e-3])
        ones = np.ones(len(points))
        return Sample(value, slope, 1e-15 * ones, ones.astype(np.int64))

    edges = [np.linspace(-1.0, 1.0, 10), np.linspace(-1.0, 1.0, 9)]
    found = zeros_by_cells(lines, edges, flatness=1e-12, max_effort=30_000)
    assert not len(found.starts) + len(found.unresolved) + len(found.flat)
    assert found.effort == 72


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e12])
def test_zeros_do_not_depend_on_the_unit_of_the_function(factor: float) -> None:
    """c (z^3 - 1) has the roots of z^3 - 1, and takes as many evaluations."""
    found = zeros(lambda z: (factor * (z**3 - 1.0), 3.0 * factor * z**2), flatness=1e-16)
    starts = found.starts[:, 0] + 1j * found.starts[:, 1]
    roots = np.exp(2j * np.pi * np.arange(3) / 3.0)
    assert not len(found.unresolved)
    assert np.abs(starts - roots[:, None]).min(axis=1).max() < 0.05
    assert found.effort < 1000


def test_a_circle_of_zeros_is_flat() -> None:
    """(r^2 - 1) times a point's direction vanishes along the unit circle."""

    def sample(points: FloatArray, _: float, __: IntArray | None) -> Sample:
        square = np.einsum("pi,pi->p", points, points)
        derivative = (square - 1.0)[:, None, None] * np.eye(2) + 2.0 * np.einsum(
            "pi,pj->pij", points, points
        )
        ones = np.ones(len(points))
        return Sample((square - 1.0)[:, None] * points, derivative, 1e-15 * ones, ones.astype(int))

    edges = [np.linspace(-2.0, 2.0, 12), np.linspace(-2.0, 2.0, 12)]
    found = zeros_by_cells(sample, edges, flatness=1e-8, max_effort=30_000)
    assert np.abs(np.linalg.norm(found.flat, axis=1) - 1.0).max() < 1e-6
    assert len(found.flat) > 20
    assert np.linalg.norm(found.starts, axis=1).max() < 0.05


def test_where_nothing_can_be_computed_little_is_spent() -> None:
    """The effort stays near a tenth of the limit, and all of the box is left open."""
    spent = []

    def unknown(points: FloatArray, _tolerance: float, _effort: IntArray | None) -> Sample:
        sample = Sample.unknown(len(points), *points.shape[1:] * 2)
        sample.effort[:] = 1000
        spent.append(sample.total_effort)
        return sample

    limit = 1e7
    found = zeros_by_cells(unknown, [np.linspace(0.0, 1.0, 11)] * 2, flatness=0.0, max_effort=limit)
    assert found.effort == sum(spent) < 0.3 * limit
    assert not len(found.starts)
    assert len(found.unresolved)


def test_cells_that_become_too_many_are_left_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a function as rough as no cell is small, no more are computed at once than twice those."""
    monkeypatch.setattr("remanent.analysis.orbits.cells._MOST_CELLS", 500)
    asked = []

    def rough(points: FloatArray, _tolerance: float, _effort: IntArray | None) -> Sample:
        asked.append(len(points))
        value = 0.1 * np.sin(1e9 * points)
        slope = 1e8 * np.cos(1e9 * points)[:, :, None] * np.eye(2)
        none = np.zeros(len(points), dtype=np.int64)
        return Sample(value, slope, np.full(len(points), 1e-12), none)

    found = zeros_by_cells(rough, [np.linspace(0.0, 1.0, 11)] * 2, flatness=0.0, max_effort=1e12)
    assert max(asked) <= 1000
    assert len(found.unresolved) > 500


def quarters(box: FloatArray) -> list[FloatArray]:
    """The four quarters of a box."""
    halves = [(low, 0.5 * (low + high), high) for low, high in box]
    return [np.array([halves[0][i : i + 2], halves[1][j : j + 2]]) for i in (0, 1) for j in (0, 1)]


def test_cells_learn_curvature_from_those_that_they_touch() -> None:
    """Cells of three sizes between uneven edges: also over corners, not over what is between."""
    edges = [np.array([0.0, 1.0, 3.0, 4.0, 8.0]), np.array([-1.0, 0.0, 0.5, 2.0, 3.0])]
    rng = np.random.default_rng(4)
    boxes = [np.array([[i, i + 1.0], [j, j + 1.0]]) for i in range(4) for j in range(4)]
    for _ in range(2):  # some are divided into four, some of these again
        parts = [[box] if rng.uniform() < 0.5 else quarters(box) for box in boxes]
        boxes = [box for some in parts for box in some]
    places = np.array(boxes)  # in numbers of edges, array (cell, coordinate, end)
    ends = np.stack([np.interp(places[:, k], np.arange(5), edges[k]) for k in (0, 1)], axis=1)
    count = len(ends)
    curvature = rng.uniform(size=count)
    curvature[:3] = _UNKNOWN
    nothing = Sample(
        np.zeros((count, 2)), np.zeros((count, 2, 2)), np.zeros(count), np.ones(count, dtype=int)
    )
    cells = Cells(
        ends.mean(axis=2), 0.5 * np.ptp(ends, axis=2), nothing,
        np.tile(curvature[:, None, None, None], (1, 2, 2, 2)), np.zeros(count, dtype=np.int64),
    )  # fmt: skip
    gap = np.maximum(places[:, None, :, 0], places[:, :, 0]) - np.minimum(
        places[:, None, :, 1], places[:, :, 1]
    )
    touching = (gap <= 1e-9).all(axis=2)
    known = np.where(curvature < _UNKNOWN, curvature, 0.0)
    exact = np.maximum(curvature, np.where(touching, known, 0.0).max(axis=1))
    found = _with_curvature_of_neighbours(cells, edges).curvature
    np.testing.assert_array_equal(found, np.broadcast_to(exact[:, None, None, None], found.shape))


@pytest.mark.parametrize("bend", [0.0, 1e6])
@pytest.mark.parametrize("share", [0.5, 1e-3])
def test_a_wide_cell_is_no_place_for_a_curve_alone(bend: float, share: float) -> None:
    """x vanishes along a line, which may be all that a small cell holds, but not half the box."""
    sample = Sample(
        np.zeros((1, 2)), np.array([[[1.0, 0.0], [0.0, 0.0]]]), np.array([1e-15]),
        np.ones(1, dtype=np.int64),
    )  # fmt: skip
    curvature = np.full((1, 2, 2, 2), bend)
    cells = Cells(
        np.zeros((1, 2)), np.full((1, 2), share), sample, curvature, np.zeros(1, dtype=np.int64)
    )
    assert may_be_flat(cells, np.array([share])).tolist() == [share == 1e-3]
