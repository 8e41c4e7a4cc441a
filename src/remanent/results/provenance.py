"""Attributes that say what made a Dataset; no clock time, so equal runs give equal results."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from remanent.models.actuator import Actuator

__all__ = ["attributes", "versions"]

#: Packages whose version can change a number.
PACKAGES = ("remanent", "numpy", "llvmlite", "xarray")


def attributes(
    actuator: object,
    drive: object,
    tolerance: float | None,
    *,
    over: Iterable[str] = (),
    scaled: bool = True,
    **settings: Any,
) -> dict[str, Any]:
    """Describe how a Dataset was made.

    Parameters
    ----------
    actuator, drive
        Values whose ``repr`` rebuilds them; `drive` may be None (equilibria).
    tolerance
        The tolerance asked for; None where nothing was integrated.
    over
        Names of the fields that were given many values: their value in the ``repr``
        is not the one that was used.
    scaled
        Whether the numbers turn to SI by what the table says of their names, see
        :func:`remanent.results.si.to_si`: the scales of the actuator are then kept.
    **settings
        What else decides the numbers (``duration``, ``every``, ``method``); numbers
        and strings.  None is left out.

    Returns
    -------
    dict
        Strings and numbers only, as netCDF wants.

    Examples
    --------
    >>> found = attributes("Actuator()", None, 1e-9, duration=100.0)
    >>> found["settings"], found["duration"], found["tolerance"]
    ('duration', 100.0, 1e-09)
    """
    given = {name: value for name, value in settings.items() if value is not None}
    found: dict[str, Any] = {
        "Conventions": "CF-1.11",
        "versions": versions(),
        **_present("actuator", _text(actuator)),
        **_present("drive", _text(drive) if drive is not None else ""),
        **_present("over", " ".join(over)),
        **_present("settings", " ".join(given)),
        **given,
    }
    if tolerance is not None:
        found["tolerance"] = float(tolerance)
    if scaled and isinstance(actuator, Actuator) and actuator.scales is not None:
        scales = actuator.scales.factors()
        found["scales"] = json.dumps({k: float(v) for k, v in scales.items()}, sort_keys=True)
    return found


@cache
def versions() -> str:
    """Names and versions of the packages whose version can change a number."""
    return ", ".join(f"{name} {_version(name)}" for name in PACKAGES)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "(not installed)"


def _present(name: str, text: str) -> dict[str, str]:
    """Keep an entry unless it is empty: netCDF knows no empty text."""
    return {name: text} if text else {}


def _text(value: object) -> str:
    return value if isinstance(value, str) else repr(value)
