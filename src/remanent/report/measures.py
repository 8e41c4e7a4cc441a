"""Numbers that verdicts are drawn from, each a small function of Datasets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._typing import FloatArray
from remanent.analysis.birkhoff import converged_digits

#: Decimal digits of agreement beyond which an average has settled super-fast.
_REGULAR_DIGITS = 5.0
#: A linear separation doubles from the first half to the whole; this leaves room.
_LINEAR_GROWTH = 4.0


@dataclass(frozen=True)
class Regularity:
    """What a long section says of each motion, arrays (prestress, temperature).

    Attributes
    ----------
    digits
        Agreement of weighted averages over both halves of the section.
    growth
        Largest separation of a neighbour over the whole, divided by that over the
        first half: about 2 where it grows in proportion to time, exponentially large
        where the motion is chaotic.
    spread
        Extent of the section in the stretch; 0 for a periodic motion.
    """

    digits: FloatArray
    growth: FloatArray
    spread: FloatArray

    @property
    def quasi_periodic(self) -> np.ndarray:
        """Both indicators say regular, and the section is not a point."""
        regular = (self.digits >= _REGULAR_DIGITS) & (self.growth <= _LINEAR_GROWTH)
        return np.asarray(regular & (self.spread > 1e-6))

    @property
    def aperiodic(self) -> np.ndarray:
        """Both indicators say irregular."""
        return np.asarray((self.digits < _REGULAR_DIGITS) & (self.growth > _LINEAR_GROWTH))


def regularity(section: xr.Dataset, neighbour: xr.Dataset) -> Regularity:
    """Judge motions by two independent indicators; see :class:`Regularity`."""
    order = ("prestress", "temperature", "period")
    x, z = (one["stretch"].transpose(*order).values for one in (section, neighbour))
    v, w = (one["stretch_rate"].transpose(*order).values for one in (section, neighbour))
    distance = np.hypot(x - z, v - w)
    half = distance.shape[-1] // 2
    growth = distance.max(axis=-1) / distance[..., :half].max(axis=-1)
    return Regularity(converged_digits(x), growth, np.ptp(x, axis=-1))


def local_amplitudes(thickness: FloatArray) -> FloatArray:
    """Half the rise or fall between successive extremes of a sampled history."""
    turning = np.flatnonzero(np.diff(np.sign(np.diff(thickness))) != 0) + 1
    return np.asarray(0.5 * np.abs(np.diff(thickness[turning])))


def beating(history: xr.Dataset, prestress: float) -> FloatArray:
    """Depth of the modulation of each motion (temperature,): 0 steady, 1 down to rest."""
    found = []
    values = history["thickness_stretch"].sel(prestress=prestress)
    for row in values.transpose("temperature", "time").values:
        a = local_amplitudes(row)
        found.append((a.max() - a.min()) / (a.max() + a.min()))
    return np.array(found)


def energy_change(history: xr.Dataset) -> FloatArray:
    """Largest departure from the first energy, array (prestress, temperature)."""
    energy = history["energy"].transpose("prestress", "temperature", "time").values
    return np.asarray(np.abs(energy - energy[..., :1]).max(axis=-1))


def decay(history: xr.Dataset) -> FloatArray:
    """Amplitude in the last quarter over that in the first, (prestress, temperature)."""
    x = history["thickness_stretch"].transpose("prestress", "temperature", "time").values
    quarter = x.shape[-1] // 4
    return np.asarray(np.ptp(x[..., -quarter:], axis=-1) / np.ptp(x[..., :quarter], axis=-1))


def swing(history: xr.Dataset) -> FloatArray:
    """Half the range of the thickness stretch, array (prestress, temperature)."""
    x = history["thickness_stretch"].transpose("prestress", "temperature", "time").values
    return np.asarray(0.5 * np.ptp(x, axis=-1))


def table(dataset: xr.Dataset, name: str) -> FloatArray:
    """A variable as an array (prestress, temperature); the first along other dimensions."""
    found = dataset[name]
    extra = {d: 0 for d in found.dims if d not in ("prestress", "temperature")}
    return np.asarray(found.isel(extra).transpose("prestress", "temperature").values)
