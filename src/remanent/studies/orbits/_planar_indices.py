"""The indices of fixed points in the plane, against how often the displacement winds around zero.

That costs little: along the centres of the outermost first cells of a search it is known already.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample, SampledFunction
from remanent.analysis.orbits.winding import winding_number

#: Error of the displacement at corners where it is not known yet.
_TOLERANCE = 1e-3


@dataclass(frozen=True)
class FirstGrid:
    """The first cells of a search in the plane.

    Attributes
    ----------
    edges : list of array
        Along the stretch and along its rate.
    is_mirrored : bool
        Whether cells at negative rates are left out: where time may be reversed, so may be the
        rates of all fixed points.
    """

    edges: list[FloatArray]
    is_mirrored: bool

    @property
    def centres(self) -> tuple[FloatArray, FloatArray]:
        """Of the cells along the stretch and along its rate."""
        stretches, rates = (0.5 * (e[1:] + e[:-1]) for e in self.edges)
        return stretches, rates

    @property
    def inner_box(self) -> FloatArray:
        """The rectangle through the centres of the outermost cells, array (2, 2).

        Of a mirrored grid, the lower side is the mirror image of the first row.
        """
        x, v = self.centres
        return np.array([(x[0], x[-1]), (-v[0] if self.is_mirrored else v[0], v[-1])])


def indices_in_box(states: FloatArray, index: IntArray, box: FloatArray) -> int:
    """The sum of the indices of points inside a box."""
    return int(index[((states > box[:, 0]) & (states < box[:, 1])).all(axis=1)].sum())


def winding_around_grid(
    displacement: SampledFunction, grid: FirstGrid, sample: Sample, max_effort: float
) -> int | None:
    """How often the displacement winds around zero along the edge of the inner box of a grid.

    Parameters
    ----------
    displacement : SampledFunction
    grid : FirstGrid
    sample : Sample
        The displacement at the centres of the cells.
    max_effort : float

    Returns
    -------
    int or None
        None where it vanishes, or nearly so, somewhere on the edge.
    """
    x, v = grid.centres
    number = np.arange(len(x) * len(v)).reshape(len(x), len(v))
    if grid.is_mirrored:
        v = np.concatenate([-v[:1], v])
        number = np.column_stack([np.full(len(x), -1), number])
    place = np.stack(np.meshgrid(x, v, indexing="ij"), axis=2)
    # Anticlockwise: to the right below, up, back above, and down.
    number, corners = (
        np.concatenate([a[:-1, 0], a[-1, :-1], a[:0:-1, -1], a[0, :0:-1]]) for a in (number, place)
    )
    known = sample.subset(number)
    new = np.flatnonzero((number < 0) | ~np.isfinite(known.value).all(axis=1))
    if new.size:
        known.update(new, displacement(corners[new], _TOLERANCE, None))
    return winding_number(displacement, corners, known, max_effort=max_effort)
