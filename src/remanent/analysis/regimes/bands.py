"""Indicators for orbits that visit several bands in turn, as regularly as a clock.

Averages over all points of such an orbit converge because of the clock.  Averages over every
k-th point, which all lie in one band, show how the motion within the bands is.
"""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.regimes.birkhoff import birkhoff_convergence_digits
from remanent.analysis.regimes.orbit_batch import OrbitBatch

#: Numbers of bands that an orbit may visit in turn.
_POSSIBLE_BAND_COUNTS = (2, 4, 8, 16, 3, 6, 12)
#: Scatter within a band relative to that of all points, at most.
_MAX_RELATIVE_BAND_SCATTER = 0.5
#: Fewest points that an average within a band is made of.
_MIN_POINTS_PER_BAND = 24
#: At the end of a cascade of doublings an orbit has many bands; every eighth point shows them.
_BAND_SCATTER_STRIDE_IN_ITERATES = 8


def convergence_digits_within_bands(batch: OrbitBatch) -> FloatArray:
    """Digits to which averages agree within a band, the fewest over bands and observables.

    For an orbit without bands it is the number of digits of all its points.
    """
    values = np.moveaxis(batch.observable_values, 1, 2)
    digits = birkhoff_convergence_digits(values).min(axis=1)
    extent = np.std(np.ascontiguousarray(values), axis=2)
    for count in _POSSIBLE_BAND_COUNTS:
        band = np.ascontiguousarray(values[..., ::count])
        with np.errstate(invalid="ignore"):
            narrow = (np.std(band, axis=2) < _MAX_RELATIVE_BAND_SCATTER * extent).any(axis=1)
        if narrow.any() and band.shape[2] >= _MIN_POINTS_PER_BAND:
            within = birkhoff_convergence_digits(band[narrow]).min(axis=1)
            digits[narrow] = np.fmin(digits[narrow], within)
    return np.asarray(digits)


def relative_band_scatter(batch: OrbitBatch) -> FloatArray:
    """Scatter of every eighth point relative to that of all, the least over observables.

    About 1 on a torus and in chaos, small where the orbit lies in 2^k narrow bands.
    """
    values = np.moveaxis(batch.observable_values, 1, 2)
    band, every = (
        np.ascontiguousarray(v) for v in (values[..., ::_BAND_SCATTER_STRIDE_IN_ITERATES], values)
    )
    with np.errstate(all="ignore"):
        return np.asarray(np.fmin.reduce(band.std(axis=2) / every.std(axis=2), axis=1))
