"""Nonlinear oscillations of hard-magnetic soft actuators, with an error for every number.

The public names are listed in ``__init__.pyi``, by family.  Each is imported when it is
first used, so that ``import remanent`` itself imports neither NumPy nor anything heavier.
"""

from __future__ import annotations

from importlib import import_module
from types import FunctionType

import lazy_loader

_lazy_attribute, _, _listed = lazy_loader.attach_stub(__name__, __file__)
# `plot` stands for the package `plots`, and the version is not imported from anywhere.
__all__: list[str] = [name for name in _listed if name != "plots"]
__all__ += ["__version__", "plot"]


def __getattr__(name: str) -> object:
    if name == "plot":
        value: object = import_module("remanent.plots")
    elif name == "__version__":
        value = import_module("importlib.metadata").version("remanent")
    elif name in __all__ or name == "plots":
        value = _explained_public_function(name, _lazy_attribute(name))
    else:
        raise AttributeError(_unknown_name_text(name), name=name)
    globals()[name] = value
    return value


def _unknown_name_text(name: str) -> str:
    """That there is no such name, and the nearest one that there is."""
    from difflib import get_close_matches

    closest = () if name.startswith("_") else get_close_matches(name, __all__, n=1)
    meant = f" Did you mean `{closest[0]}`?" if closest else ""
    return f"No remanent attribute {name}.{meant}"


def _explained_public_function(name: str, value: object) -> object:
    """A public function, whose unknown names are told in words; other values as they are.

    It is known by its public name, so that it can be pickled.
    """
    if not isinstance(value, FunctionType):
        return value
    from remanent._calls import explained  # half of the time of the import

    function = explained(value)
    function.__module__, function.__qualname__ = __name__, name
    return function


def __dir__() -> list[str]:
    own = {name for name in globals() if name.startswith("__")}
    return sorted({*own, *__all__})
