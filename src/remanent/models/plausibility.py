"""Values that are allowed but look like a mistake."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from remanent._errors import warn_of_input
from remanent._typing import ArrayLike

#: A temperature in kelvin below this is probably meant in degrees Celsius.
MIN_PLAUSIBLE_TEMPERATURE: Final = 100.0

#: The rating of plain NdFeB magnets, 80 degrees Celsius, in kelvin.
MAX_MAGNET_TEMPERATURE: Final = 353.15


def warn_of_implausible_temperatures(values: Mapping[str, ArrayLike]) -> None:
    """Warn of temperatures that look like degrees Celsius or are above a magnet's rating.

    Parameters
    ----------
    values : mapping of name to array
        Numeric fields of an actuator, single or in a batch; those that are missing are fine.
    """
    for name in ("temperature", "reference_temperature"):
        kelvin = np.asarray(values.get(name, MIN_PLAUSIBLE_TEMPERATURE))
        low = kelvin[(kelvin > 0.0) & (kelvin < MIN_PLAUSIBLE_TEMPERATURE)]
        if low.size:
            warn_of_input(
                f"`{name}` is below {MIN_PLAUSIBLE_TEMPERATURE:g} K: {low.flat[0]:g} K. "
                "Temperatures are in kelvin. Pass t + 273.15 for t degrees Celsius."
            )
    depends = np.asarray(values.get("magnet.temperature_coefficient", 0.0)) != 0.0
    if np.any(depends & (np.asarray(values.get("temperature", 0.0)) > MAX_MAGNET_TEMPERATURE)):
        warn_of_input(
            f"`temperature` is above {MAX_MAGNET_TEMPERATURE:g} K (80 degrees Celsius) somewhere, "
            "the rating of plain NdFeB magnets: a constant temperature coefficient is a guess "
            "there. Use one that was measured at that temperature, or stay below."
        )
