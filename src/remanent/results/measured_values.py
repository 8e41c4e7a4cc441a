"""Columns of measured values as dimensionless numbers."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd

from remanent import _units
from remanent._arrays import is_quantity, is_time_or_date, without_wrapping
from remanent._checks import as_float_array, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.actuator import Actuator
from remanent.models.scaling import Scales
from remanent.models.system import System
from remanent.results.quantities import dimensionless_numbers, require_scales
from remanent.results.schema import QuantityKind, describe

__all__ = ["dimensionless_column"]

#: Ending of the name of a standard deviation.
_ERROR_SUFFIX: Final = "_error"
#: Stretches of the thickness, and of the edges by number.
_THICKNESS_STRETCHES: Final = frozenset(
    {"thickness_stretch", "mean_thickness_stretch", "amplitude", "maximum", "minimum",
     "thickness_stretch_rate"}
)  # fmt: skip
_EDGE_STRETCHES: Final = frozenset({"stretch", "stretch_rate", "stretch_1", "stretch_1_rate"})
_SECOND_EDGE_STRETCHES: Final = frozenset({"stretch_2", "stretch_2_rate"})


def dimensionless_column(
    name: str, values: Any, unit: str | None, argument: str, actuator: System | None
) -> FloatArray:
    """The values of a column without their unit, an array (row,).

    Parameters
    ----------
    name : str
        The variable.
    values : array_like
        What the column holds.
    unit : str or None
        Its unit; None or ``"1"`` where it is dimensionless.
    argument : str
        What the message calls it.
    actuator : System or None
        Its sizes convert.

    Raises
    ------
    InputError
        Values that are no numbers or infinite, a unit that is unknown or of another dimension,
        or units without the sizes of an actuator.
    """
    scales = None if actuator is None else actuator.scales
    content = _as_plain_times(values)
    base = name.removesuffix(_ERROR_SUFFIX)
    kind = describe(base).kind
    if is_time_or_date(content):
        return _one_row(argument, dimensionless_numbers(argument, content, kind, scales), content)
    if is_quantity(content):
        content, unit = _magnitude_and_unit(argument, content)
    numbers = _measured_numbers(argument, content)
    if unit in {None, "", "1"}:
        return numbers
    if kind is QuantityKind.TEMPERATURE and base != name:
        return _temperature_differences(argument, numbers, str(unit))
    quantity = _units.with_unit(argument, numbers, str(unit))
    if not quantity.dimensionless and kind in {QuantityKind.NONE, QuantityKind.RATE}:
        size = _size_of(argument, base, f"values in {unit}", scales, actuator)
        if size is not None and "[length]" in str(quantity.dimensionality):
            quantity = quantity / _units.with_unit(argument, np.asarray(size), "m")
    if kind not in {QuantityKind.NONE, QuantityKind.TEMPERATURE}:
        require_scales(argument, f"values in {unit}", scales)
    return dimensionless_numbers(argument, quantity, kind, scales)


def _as_plain_times(values: Any) -> Any:
    """Dates as times since the first of them; anything else as it is."""
    if isinstance(values, pd.Series | pd.Index) and values.dtype.kind == "M":
        return (values - values.min()).to_numpy()
    content = without_wrapping(values)
    if getattr(getattr(content, "dtype", None), "kind", "") == "M" and content.size:
        return content - np.nanmin(content)
    is_series_of_times = isinstance(content, pd.Series) and content.dtype.kind == "m"
    return content.to_numpy() if is_series_of_times else content


def _magnitude_and_unit(argument: str, quantity: Any) -> tuple[Any, str]:
    """Numbers and unit of a pint quantity, or of a list of them."""
    first = quantity[0] if isinstance(quantity, list | tuple) else quantity
    unit = f"{first.units:~D}".replace(" ", "")
    return _units.magnitude_in_unit(argument, quantity, str(first.units)), unit


def _measured_numbers(argument: str, values: Any) -> FloatArray:
    """A column as floats, gaps as NaN, if nothing in it is infinite."""
    if isinstance(values, pd.Series) and values.dtype.kind not in "iufb":
        _require_numeric_cells(argument, values)
    numbers = as_float_array(
        argument,
        values,
        what="measured values",
        why="Everything but its heading is measured.",
        fix="Leave other rows out of the file.",
        gaps=True,
    )
    return _one_row(argument, numbers, values)


def _one_row(argument: str, numbers: FloatArray, values: object) -> FloatArray:
    """An array (row,) of a column, which other programs write as a matrix of one column."""
    is_column = max(numbers.shape, default=1) == numbers.size
    infinite = np.flatnonzero(np.isinf(numbers))
    if not is_column or infinite.size:
        row = f" in row {infinite[0] + 1}" if infinite.size else ""
        raise InputError(
            argument,
            must="be one column of finite numbers",
            got=f"{numbers.ravel()[infinite[0]]:g}{row}" if row else shortened_repr(values),
            why="Each row is one measurement.",
            fix="Leave such rows out, or write NaN where nothing was measured.",
        )
    return numbers.ravel()


def _require_numeric_cells(argument: str, values: pd.Series[Any]) -> None:
    """Refuse a column in which something is no number, and say where."""
    bad = pd.to_numeric(values, errors="coerce").isna() & values.notna()
    if bad.any():
        row = int(np.flatnonzero(bad.to_numpy())[0])
        raise InputError(
            argument,
            must="be real numbers (measured values)",
            got=f"{shortened_repr(values.iloc[row])} in row {row + 1}",
            why="Everything but its heading is measured.",
            fix="Leave such rows out, or write NaN where nothing was measured.",
        )


def _temperature_differences(argument: str, numbers: FloatArray, unit: str) -> FloatArray:
    """Deviations of temperatures in kelvin: half a degree Celsius is half a kelvin."""
    steps = [
        np.asarray(_units.magnitude_in_unit(argument, _units.with_unit(argument, t, unit), "K"))
        for t in (numbers, np.zeros_like(numbers))
    ]
    return np.asarray(steps[0] - steps[1])


def _size_of(
    argument: str, name: str, got: str, scales: Scales | None, actuator: System | None
) -> float | None:
    """The size of the undeformed block, in metres, over which a stretch is a length."""
    if name not in _THICKNESS_STRETCHES | _EDGE_STRETCHES | _SECOND_EDGE_STRETCHES:
        return None
    length = 2.0 * require_scales(argument, got, scales).half_length
    if not isinstance(actuator, Actuator):
        return None
    if name in _THICKNESS_STRETCHES:
        return float(length * np.sqrt(actuator.c))
    edges = (1.0, 1.0) if actuator.edges is None else actuator.edges
    return float(length * edges[name in _SECOND_EDGE_STRETCHES])
