"""Which unstated choices bring the six published resonances back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import xarray as xr

from remanent._typing import FloatArray
from remanent.report.settings import AGREEMENT, LAWS, PRESTRESSES, PUBLISHED, TEMPERATURES, Setting
from remanent.results import build, provenance
from remanent.studies.response.frequency_response import frequency_response

#: Reference temperatures T0 at which the misfit is computed, K.
REFERENCE_TEMPERATURES: Final = np.arange(287.0, 304.0, 2.0)
#: Amplitudes b0 at which the misfit is computed.
AMPLITUDES: Final = np.round(np.arange(0.34, 0.4401, 0.01), 2)
#: Lengths of the response window at which the misfit is computed.
WINDOWS: Final = (50.0, 100.0, 150.0)
#: Frequencies searched by law: first, last, count; m = b₀² sin ωτ resonates at twice the
#: published ones.
_OMEGAS: Final = {"sin2": (0.7, 1.5, 41), "cos2": (0.7, 1.5, 41), "sin": (0.7, 3.0, 116)}
#: Error of amplitudes that places a maximum within the width below.
_TOLERANCE: Final = 1e-4
#: Width to which a resonance is read: two parts of eight of a step of the table, with room
#: for rounding.
_WIDTH: Final = 5.1e-3


def misfits(
    law: str, windows: tuple[float, ...], report: Callable[[], None], *, every: int = 1
) -> xr.Dataset:
    """Largest difference from the published resonances, over T₀, b₀ and the window.

    Parameters
    ----------
    law : str
        Name in :data:`~remanent.report.settings.LAWS`.
    windows : tuple of float
        Lengths of the response window.
    report : callable
        Called after each window.
    every : int
        Use every so many values of T₀ and b₀ only.

    Returns
    -------
    xarray.Dataset
        ``misfit`` (law, window, reference_temperature, b) and the ``resonance``
        (law, window, reference_temperature, b, temperature, prestress) behind it.
    """
    tables = []
    for window in windows:
        grid = REFERENCE_TEMPERATURES[::every], AMPLITUDES[::every]
        tables.append(_resonances(law, window, *grid))
        report()
    resonance = np.stack(tables)[None]
    misfit = np.abs(resonance - np.array(PUBLISHED).T).max(axis=(-2, -1))
    dims = ("law", "window", "reference_temperature", "b")
    setting = Setting(law=law)
    return build.dataset(
        {
            "misfit": (dims, misfit),
            "resonance": ((*dims, "temperature", "prestress"), resonance),
        },
        {
            "law": (("law",), np.array([LAWS[law].symbol])),
            "window": (("window",), np.array(windows)),
            "reference_temperature": (("reference_temperature",), REFERENCE_TEMPERATURES[::every]),
            "b": (("b",), AMPLITUDES[::every]),
            "temperature": (("temperature",), np.array(TEMPERATURES)),
            "prestress": (("prestress",), np.array(PRESTRESSES)),
        },
        provenance.attributes(
            setting.actuator, setting.drive(1.0), _TOLERANCE, over=dims[1:], width=_WIDTH
        ),
    )


def _resonances(
    law: str, window: float, temperatures: FloatArray, amplitudes: FloatArray
) -> FloatArray:
    """Array (reference_temperature, b, temperature, prestress)."""
    field, values = LAWS[law].field(amplitudes)
    response = frequency_response(
        Setting().actuator,
        LAWS[law].drive(0.4, 1.0),
        np.linspace(*_OMEGAS[law]),
        duration=window,
        tolerance=_TOLERANCE,
        resonance_width=_WIDTH,
        over={
            "reference_temperature": temperatures,
            field: values,
            "temperature": TEMPERATURES,
            "prestress": PRESTRESSES,
        },
    )
    order = ("reference_temperature", field, "temperature", "prestress")
    return np.asarray(response["resonance"].transpose(*order).values)


def admissible(misfit: xr.Dataset, law: str) -> list[Setting]:
    """Settings that bring all six resonances back: the best of each window."""
    values = misfit["misfit"].isel(law=0).transpose("window", "reference_temperature", "b").values
    agreeing = np.argwhere(values <= AGREEMENT)
    by_window = [agreeing[agreeing[:, 0] == w] for w in range(values.shape[0])]
    best = [rows[np.argmin(values[tuple(rows.T)])] for rows in by_window if rows.size]
    settings = [
        Setting(float(AMPLITUDES[j]), float(REFERENCE_TEMPERATURES[i]), float(WINDOWS[w]), law)
        for w, i, j in best
    ]
    return list(dict.fromkeys(settings))
