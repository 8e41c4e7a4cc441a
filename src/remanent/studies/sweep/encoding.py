"""Variables of results as a store holds them: words as numbers, and what stands for nothing."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import RemanentError
from remanent.analysis.orbits.stability import Stability
from remanent.analysis.regimes.labels import Regime
from remanent.results.build import padding_of
from remanent.results.stores import FLAG_LABELS, TEXT_DTYPE

_REGIMES: Final = tuple(one.meaning for one in Regime)
#: Words that a variable can have; other text is kept as text.
WORDS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "regime": _REGIMES,
        "attractor_regime": _REGIMES,
        "stability": tuple(one.meaning for one in Stability),
        "special_kind": ("fold", "period doubling", "branch point", "Neimark-Sacker"),
        "resonance_kind": (
            "undecided", "primary", "superharmonic", "subharmonic", "ultrasubharmonic",
            "parametric",
        ),
        "symmetry": ("undecided", "kept", "lost"),
    }
)  # fmt: skip


def stored_values(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """Values as the store holds them."""
    if values.dtype.kind not in "UTO":
        return values
    words = WORDS.get(name)
    if words is None:
        return values.astype(object)
    codes = np.full(values.shape, -1, dtype=np.int8)
    for code, word in enumerate(words):
        codes[values == word] = code
    unknown = (codes < 0) & (values != "")
    if unknown.any():
        raise RemanentError(
            f"`{name}` has a word without a number, {values[unknown][0]!r}. "
            "Report this as a fault of remanent."
        )
    return codes


def stored_dtype(name: str, dtype: np.dtype[Any]) -> Any:
    """The type that the store has for values of this type."""
    if dtype.kind not in "UTO":
        return dtype
    return np.dtype(np.int8) if name in WORDS else str


def stored_attributes(name: str, variable: xr.Variable) -> dict[str, Any]:
    """Attributes of a stored variable, with what a reader needs to have the words back."""
    attributes = {str(key): plain_attribute(value) for key, value in variable.attrs.items()}
    words = WORDS.get(name)
    if variable.dtype.kind in "UTO" and words:
        attributes |= {
            "flag_values": list(range(len(words))),
            "flag_meanings": " ".join("_".join(word.split()) for word in words),
            FLAG_LABELS: list(words),
        }
    if variable.dtype.kind in "UTO":
        attributes[TEXT_DTYPE] = "str"
    return attributes


def fill_value(name: str, dtype: np.dtype[Any]) -> Any:
    """What stands where nothing was computed: NaN, -1, no text; status 0, not computed."""
    return -1 if dtype.kind in "UTO" and name in WORDS else padding_of(dtype, name)


def plain_attribute(value: Any) -> Any:
    """An attribute as JSON holds it: arrays and NumPy's numbers as those of Python."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
