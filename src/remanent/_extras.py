"""Packages that only some commands need, and how to get those that are missing."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from types import MappingProxyType
from typing import Final

from remanent._errors import RemanentError

#: Packages of each extra of the installation.
PACKAGES_OF_EXTRA: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "cluster": ("dask", "distributed", "zarr"),
        "paper": ("jinja2", "plotly"),
        "studies": ("zarr",),
        "web": ("fastapi", "plotly", "uvicorn", "websockets"),
    }
)


def require_extra(extra: str, purpose: str) -> None:
    """Say how to install what is missing.

    Parameters
    ----------
    extra : str
        Of the installation, a key of :data:`PACKAGES_OF_EXTRA`.
    purpose : str
        What needs it, the beginning of a sentence.

    Raises
    ------
    RemanentError
        A package of the extra is not installed.
    """
    missing = [name for name in PACKAGES_OF_EXTRA[extra] if find_spec(name) is None]
    if missing:
        raise RemanentError(
            f"{purpose[:1].upper()}{purpose[1:]} needs {', '.join(missing)}. "
            f"Install it with `pip install 'remanent[{extra}]'`."
        )
