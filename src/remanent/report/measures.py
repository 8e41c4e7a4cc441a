"""Numbers that verdicts are drawn from, each a small function of Datasets."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._typing import FloatArray


def separation_growth(section: xr.Dataset, neighbour: xr.Dataset) -> FloatArray:
    """How much further neighbours part over the full run than over its first half.

    Array (prestress, temperature): about 2 where their separation grows in proportion to
    time, exponentially large where the motion is chaotic.
    """
    order = ("prestress", "temperature", "period")
    stretch, rate = (
        (section[name] - neighbour[name]).transpose(*order).values
        for name in ("stretch", "stretch_rate")
    )
    distance = np.hypot(stretch, rate)
    half = distance.shape[-1] // 2
    return np.asarray(distance.max(axis=-1) / distance[..., :half].max(axis=-1))


def local_amplitudes(thickness: FloatArray) -> FloatArray:
    """Half the rise or fall between successive extremes of a sampled history."""
    turning = np.flatnonzero(np.diff(np.sign(np.diff(thickness))) != 0) + 1
    return np.asarray(0.5 * np.abs(np.diff(thickness[turning])))


def beating_depth(history: xr.Dataset, prestress: float) -> FloatArray:
    """Depth of the modulation of each motion (temperature,): 0 steady, 1 down to rest."""
    depths = []
    values = history["thickness_stretch"].sel(prestress=prestress)
    for row in values.transpose("temperature", "time").values:
        a = local_amplitudes(row)
        depths.append((a.max() - a.min()) / (a.max() + a.min()))
    return np.array(depths)


def largest_energy_change(history: xr.Dataset) -> FloatArray:
    """Largest departure from the first energy, array (prestress, temperature)."""
    energy = history["energy"].transpose("prestress", "temperature", "time").values
    return np.asarray(np.abs(energy - energy[..., :1]).max(axis=-1))


def late_over_early_range(history: xr.Dataset) -> FloatArray:
    """Range of λ₃ in the last quarter over that in the first, array (prestress, temperature)."""
    x = history["thickness_stretch"].transpose("prestress", "temperature", "time").values
    quarter = x.shape[-1] // 4
    return np.asarray(np.ptp(x[..., -quarter:], axis=-1) / np.ptp(x[..., :quarter], axis=-1))


def stretch_half_range(history: xr.Dataset) -> FloatArray:
    """Half the range of the thickness stretch, array (prestress, temperature)."""
    x = history["thickness_stretch"].transpose("prestress", "temperature", "time").values
    return np.asarray(0.5 * np.ptp(x, axis=-1))


def array_by_prestress_and_temperature(dataset: xr.Dataset, name: str) -> FloatArray:
    """A variable as an array (prestress, temperature); the first along other dimensions."""
    variable = dataset[name]
    extra = {d: 0 for d in variable.dims if d not in ("prestress", "temperature")}
    return np.asarray(variable.isel(extra).transpose("prestress", "temperature").values)
