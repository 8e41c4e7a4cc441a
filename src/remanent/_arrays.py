"""The one gate through which arrays of numbers come in.

NumPy would let many things through without a word, and change what they mean: a masked entry
as the number behind the mask, ``"1"`` as 1, a date as its days, a quantity without its unit, a
complex number as its real part, a truth value as 0 or 1.  All of it is refused here, with the
reason.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import date, timedelta
from typing import Any, Final

import numpy as np

from remanent._errors import InputError, shortened_repr
from remanent._machine import available_memory_bytes
from remanent._typing import FloatArray

__all__ = [
    "as_float_array",
    "is_increasing",
    "is_quantity",
    "is_time_or_date",
    "remedy_for_kind",
    "without_wrapping",
]

#: Kinds of NumPy data that are real numbers: integers, floats.
_REAL_DTYPE_KINDS: Final = frozenset("iuf")
#: Kinds of NumPy data that are lengths of time, or dates.
_TIME_DTYPE_KINDS: Final = frozenset("mM")
#: Arrays with more entries are copied only where the copy takes less than half of the memory.
_LARGE_ENTRY_COUNT: Final = 10**7
#: How the least number of entries is said in a message.
_NUMBER_WORDS: Final[Mapping[int, str]] = {1: "one", 2: "two"}
#: How the number of dimensions is said in a message.
_SHAPE_WORDS: Final[Mapping[int | None, str]] = {None: "", 0: "one of ", 1: "a sequence of "}


def as_float_array(
    name: str,
    value: object,
    *,
    what: str,
    why: str,
    fix: str,
    ndim: int | None = None,
    least: int = 0,
    finite: bool = False,
    gaps: bool = False,
) -> FloatArray:
    """`value` as a new array of floats.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : array_like
        What was passed for it.
    what : str
        What it must be, in the plural: ``"frequencies"``.
    why, fix : str
        Reason and remedy, a sentence each; see :class:`~remanent._errors.InputError`.
    ndim : int, optional
        Number of dimensions; by default any.
    least : int
        Least number of entries.
    finite : bool
        Whether NaN and infinity are refused.
    gaps : bool
        Whether a masked entry is NaN; otherwise it is refused.

    Returns
    -------
    array of float
        The caller may keep and change it.

    Raises
    ------
    InputError
        If it is not such an array.
    """
    content = without_wrapping(value)
    fix = remedy_for_kind(content) or fix
    try:
        array = _plain_array(content, gaps)
    except MemoryError:
        raise _too_large_error(name, value) from None
    if array.size > _LARGE_ENTRY_COUNT and 16.0 * array.size > available_memory_bytes():
        raise _too_large_error(name, value)
    sound = array.dtype.kind in _REAL_DTYPE_KINDS and array.size >= least
    if sound and (ndim is None or array.ndim == ndim):
        with np.errstate(over="ignore"):  # of longer floats
            floats = np.array(array, dtype=np.float64)
        if not finite or np.isfinite(floats).all():
            return floats
    shape = _SHAPE_WORDS.get(ndim, f"{ndim}-dimensional: ")
    raise InputError(
        name,
        must=f"be {shape}{'finite' if finite else 'real'} numbers ({what})"
        + (f", at least {_NUMBER_WORDS.get(least, str(least))}" if least else ""),
        got=shortened_repr(value),
        why=why,
        fix=fix,
    )


def _too_large_error(name: str, value: object) -> InputError:
    return InputError(
        name,
        must="fit into memory twice",
        got=f"numbers of shape {getattr(value, 'shape', 'unknown')}",
        why="They are copied, as the caller may change them; nothing was copied yet.",
        fix="Pass fewer of them at a time.",
    )


def without_wrapping(value: object) -> Any:
    """The array within a labelled array of xarray; anything else as it is."""
    return getattr(value, "data", value) if hasattr(value, "dims") else value


def is_quantity(value: object) -> bool:
    """Whether this is a quantity with a unit, or a list that begins with one."""
    content = without_wrapping(value)
    if isinstance(content, list | tuple) and content:
        content = content[0]
    return hasattr(content, "magnitude") and hasattr(content, "to")


def is_time_or_date(value: object) -> bool:
    """Whether this is a length of time or a date, of Python or NumPy, or an array of them."""
    content = without_wrapping(value)
    if isinstance(content, list | tuple) and content:
        content = content[0]
    if isinstance(content, timedelta | date):
        return True
    return getattr(getattr(content, "dtype", None), "kind", "") in _TIME_DTYPE_KINDS


def is_increasing(values: FloatArray) -> bool:
    """Whether entries are finite and each is greater than the one before; little memory."""
    ends = values.size and np.isfinite(values[[0, -1]]).all()
    return bool(ends and (values[1:] > values[:-1]).all())


def _plain_array(content: Any, gaps: bool) -> np.ndarray[Any, Any]:
    """An array without mask or unit; one of objects where it cannot be one of numbers."""
    refused = np.empty(0, dtype=np.object_)
    if is_quantity(content) or is_time_or_date(content):
        return refused
    if np.ma.is_masked(content):
        return content.astype(np.float64).filled(np.nan) if gaps and _is_real(content) else refused
    try:
        if hasattr(content, "to_numpy") and hasattr(content, "isna"):  # of pandas, NA as NaN
            has_gap = bool(np.any(content.isna()))
            if has_gap and getattr(content.dtype, "kind", "O") in _REAL_DTYPE_KINDS:
                return np.asarray(content.to_numpy(dtype=np.float64, na_value=np.nan))
        return np.asarray(content)
    except MemoryError:
        raise
    except Exception:  # rows of different lengths, a class of its own ways
        return refused


def _is_real(array: np.ma.MaskedArray[Any, Any]) -> bool:
    return array.dtype.kind in _REAL_DTYPE_KINDS


def remedy_for_kind(content: Any) -> str:
    """What to do about data of another kind; nothing where its kind is not at fault."""
    if isinstance(content, str) and content[:1].isdigit() and content[-1:].isalpha():
        return (
            "Pass a plain number (temperatures in kelvin). An actuator that Actuator.from_si "
            "made converts units: actuator.load('200 mT'), .frequency('50 Hz'), .time('20 ms'), "
            ".viscosity('2 Pa s') or .stress('1 kPa')."
        )
    if is_quantity(content):
        return (
            "Convert it first: actuator.time(...), .frequency(...), .load(...) or .stress(...) "
            "of an actuator that Actuator.from_si made."
        )
    if is_time_or_date(content):
        return (
            "Pass times in units of tau: actuator.time(...) converts seconds, for an actuator "
            "that Actuator.from_si made."
        )
    if np.ma.is_masked(content):
        return "Leave the masked entries out: values.compressed()."
    return ""
