"""How finely the period map resolves a point: a pilot run for the cell that holds it.

Most points of a branch need several times the coarsest resolution, and a run that was too
coarse is thrown away.  So a good first guess pays.  It must not come from earlier calls or
from the other points of a call: the image of a point would then depend on them in its last
digits.  Here it is a function of the point alone.  States and parameters are divided into
cells, and all points of a cell begin with the resolution that one run from the centre of the
cell asks for.  Cells also make neighbours agree, which a kernel needs: it advances sixteen
points in the time of one if their resolutions are equal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.resolution import round_up_resolution
from remanent.integrate.maps.period_map import PeriodMapImage

#: Double steps per period of the first pilot run, and the fewest that are foreseen.
FIRST_RESOLUTION = 8
#: Share of the tolerance that the error is to have: at 0.5 the noise of a branch hid a window of
#: instability 7e-6 wide.
_TARGET_ERROR_OVER_TOLERANCE = 0.25
#: Factor of refinement up to which the error of a run foretells the resolution.
_MAX_EXTRAPOLATED_REFINEMENT = 8.0
#: Smallest factor from one pilot run to the next.
_MIN_REFINEMENT = 2.0
#: Largest factor from one pilot run to the next.
_MAX_REFINEMENT = 4.0
#: Smallest factor of coarsening after a run that was finer than needed.
_MIN_COARSENING = 0.25
#: Resolution that is foreseen where no pilot run comes near the tolerance: points of such a
#: cell may be better off than its centre, so they begin coarsely.
_UNRELIABLE_RESOLUTION = 32
#: Binary digits of a parameter that tell its cell.
_PARAMETER_CELL_BITS = 4
#: Binary exponent that no parameter is below.
_EXPONENT_BELOW_ALL_PARAMETERS = -2000

#: ``run(states, parameters, resolution)``: the map with exactly these resolutions.
PilotRunFunction = Callable[[FloatArray, FloatArray, IntArray], PeriodMapImage]
#: One cell, and the iterate of the map that is asked of it.
CellKey = tuple[int, bool, bytes]


@dataclass(frozen=True)
class PilotResolution:
    """Resolutions to begin with, from one pilot run for each cell.

    The pilot runs are kept in `resolution_of_cell`, which grows with each new cell.  It holds
    values of a function of the cell alone: what it holds decides how long a call takes, never
    its result.

    Attributes
    ----------
    period_tolerance : float
        Of the error that a period adds.
    convergence_order : int
        By which power of the resolution the error falls.
    finest_resolution : int
        Largest resolution.
    state_cell_bits : int
        Binary digits of a state variable that tell its cell; the cells of numbers below 1
        are as large as those at 1.
    resolution_of_cell : dict of Cell to int
    """

    period_tolerance: float
    convergence_order: int
    finest_resolution: int
    state_cell_bits: int
    resolution_of_cell: dict[CellKey, int] = field(default_factory=dict, repr=False, compare=False)

    def __call__(
        self,
        run: PilotRunFunction,
        states: FloatArray,
        parameters: FloatArray,
        *,
        iterate: int,
        half: bool,
    ) -> IntArray:
        """Resolution to begin with at each of many points, array (point,).

        Parameters
        ----------
        run : PilotRun
        states : array (point, state)
        parameters : array (point, parameter)
        iterate : int
            Periods that `run` lasts.
        half : bool
            Whether it lasts half a period more.
        """
        centres = np.hstack(
            [
                _round_to_bits(states, self.state_cell_bits, 0),
                _round_to_bits(parameters, _PARAMETER_CELL_BITS, _EXPONENT_BELOW_ALL_PARAMETERS),
            ]
        )
        cells: list[CellKey] = [(iterate, half, row.tobytes()) for row in centres]
        unseen = {cell: k for k, cell in enumerate(cells) if cell not in self.resolution_of_cell}
        if unseen:
            rows = centres[list(unseen.values())]
            wanted = self._pilot_resolutions(run, *np.split(rows, [states.shape[1]], axis=1))
            self.resolution_of_cell.update(zip(unseen, wanted.tolist(), strict=True))
        return np.array([self.resolution_of_cell[cell] for cell in cells], dtype=np.int64)

    def resolutions_sufficient_in_hindsight(self, image: PeriodMapImage) -> IntArray:
        """Resolutions that would have been enough for an image, array (point,)."""
        with np.errstate(all="ignore"):
            factor = (
                image.largest_period_error / (_TARGET_ERROR_OVER_TOLERANCE * self.period_tolerance)
            ) ** (1.0 / self.convergence_order)
        factor = np.where(np.isfinite(factor), factor, 1.0).clip(_MIN_COARSENING, 1.0)
        foreseen = round_up_resolution(np.maximum(image.resolution * factor, FIRST_RESOLUTION))
        return np.asarray(np.minimum(foreseen, self.finest_resolution))

    def _pilot_resolutions(
        self, run: PilotRunFunction, states: FloatArray, parameters: FloatArray
    ) -> IntArray:
        """Resolutions that the errors of pilot runs ask for, array (point,)."""
        wanted = np.full(len(states), FIRST_RESOLUTION)
        resolution = np.full(len(states), FIRST_RESOLUTION)
        # Without finite numbers there is nothing to run; such points fail at any resolution.
        pending = np.flatnonzero(np.isfinite(states).all(axis=1) & np.isfinite(parameters).all(1))
        while pending.size:
            image = run(states[pending], parameters[pending], resolution[pending])
            with np.errstate(all="ignore"):
                factor = (
                    image.largest_period_error
                    / (_TARGET_ERROR_OVER_TOLERANCE * self.period_tolerance)
                ) ** (1.0 / self.convergence_order)
            reliable = np.isfinite(factor) & (factor <= _MAX_EXTRAPOLATED_REFINEMENT)
            foreseen = round_up_resolution(
                np.maximum(np.where(reliable, factor, 1.0) * image.resolution, FIRST_RESOLUTION)
            )
            coarse = np.minimum(image.resolution, _UNRELIABLE_RESOLUTION)
            wanted[pending] = np.where(reliable, foreseen, coarse)
            growth = np.where(np.isfinite(factor), factor, _MIN_REFINEMENT)
            finer = round_up_resolution(
                image.resolution * growth.clip(_MIN_REFINEMENT, _MAX_REFINEMENT)
            )
            again = ~reliable & (image.resolution < self.finest_resolution)
            pending = pending[again]
            resolution[pending] = np.minimum(finer[again], self.finest_resolution)
        return np.asarray(np.minimum(wanted, self.finest_resolution))


def _round_to_bits(values: FloatArray, bits: int, floor: int) -> FloatArray:
    """Numbers with some of their binary digits, as if none were below 2**floor / 2.

    Adding 0 turns -0 into 0, so that both lie in the same cell.
    """
    _, exponent = np.frexp(values)
    width = np.ldexp(1.0, np.maximum(exponent, floor) - bits)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.rint(values / width) * width + 0.0)
