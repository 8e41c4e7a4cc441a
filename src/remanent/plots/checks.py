"""What every picture is given: a Dataset, axes, flags, names, and words for Matplotlib."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from remanent._arrays import is_quantity
from remanent._calls import require_fitting_arguments
from remanent._checks import require_flag, shortened_repr
from remanent._errors import InputError, error_sentence
from remanent.plots.ensemble import MissingVariablesError
from remanent.results.checks import require_unstacked_dataset
from remanent.results.provenance import observable_name
from remanent.results.schema import is_described

__all__ = ["checked_picture"]

_Arguments = ParamSpec("_Arguments")
_Artists = TypeVar("_Artists")
#: What Matplotlib raises of words that it does not know, or values that these do not have.
_MATPLOTLIB_ERRORS = (
    AttributeError, TypeError, ValueError, KeyError, RuntimeError, ArithmeticError,
)  # fmt: skip
#: Most numbers among one word for Matplotlib.
_MOST_NUMBERS_IN_A_WORD = 1_000_000
#: Variables of complex numbers, of which pictures show the moduli.
_COMPLEX_VARIABLES = frozenset(
    {"multipliers", "transverse_multipliers", "harmonics", "eigenvalues"}
)
#: Arguments that name what is drawn along an axis.
_DRAWN_ARGUMENTS = frozenset({"variable", "x", "y", "quantity", "parameter"})
#: Those of pictures that draw words too.
_ARGUMENTS_OF_WORDS = {"map": frozenset({"variable"}), "curve": frozenset({"x"})}


def checked_picture(
    draw: Callable[_Arguments, _Artists], results_of: tuple[str, ...] = ()
) -> Callable[_Arguments, _Artists]:
    """The picture, whose arguments are checked before anything is drawn.

    Parameters
    ----------
    draw : callable
        A function of a `dataset`, names of variables, axes `ax`, flags, and further words that
        Matplotlib takes.
    results_of : tuple of str
        The public functions whose results it draws; empty where it draws any.

    Returns
    -------
    callable
        The same function; a bad argument raises :class:`~remanent.InputError`.
    """
    signature = inspect.signature(draw)
    words = next((n for n, p in signature.parameters.items() if p.kind is p.VAR_KEYWORD), "")

    @wraps(draw)
    def picture(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Artists:
        require_fitting_arguments(draw, args, kwargs)
        given = signature.bind(*args, **kwargs).arguments
        _require_arguments(draw.__name__, signature, words, given)
        try:
            with np.errstate(all="ignore"):  # of results at infinity
                return draw(*args, **kwargs)
        except MissingVariablesError as error:
            raise _other_result_error(error, results_of) from None
        except InputError:
            raise
        except _MATPLOTLIB_ERRORS as error:
            if not given.get(words):
                raise
            raise _unknown_words_error(given[words], draw.__name__, error) from error

    return picture


def _require_arguments(
    picture: str, signature: inspect.Signature, words: str, given: Mapping[str, Any]
) -> None:
    """Refuse arguments of which no picture can be made."""
    for name, value in given.items():
        if name != words:
            _require_kind(name, value, signature.parameters[name])
    for name, value in given.items():
        if isinstance(value, xr.Dataset):
            _require_kinds_of_results(name, value)
    _require_numbers(picture, given)
    if picture == "phase":
        _require_same_dimensions(given)
    _require_plain_words(given.get(words, {}))


def _require_kind(name: str, value: object, parameter: inspect.Parameter) -> None:
    """Refuse a value of another kind than the argument's."""
    kind = str(parameter.annotation)
    if name == "dataset":
        require_unstacked_dataset(name, value)
    elif kind.startswith("xr.Dataset"):
        if value is not None or parameter.default is parameter.empty:
            require_unstacked_dataset(name, value)
    elif name == "ax":
        _require_axes(value)
    elif isinstance(parameter.default, bool):
        require_flag(name, value)
    elif kind.startswith("str"):
        several = "Sequence" in kind and isinstance(value, list | tuple) and len(value) > 0
        for entry in list(value) if several else [value]:  # type: ignore[call-overload]
            if not isinstance(entry, str) and not (entry is None and parameter.default is None):
                raise InputError(
                    name,
                    must="name a variable" if "Sequence" not in kind else "name variables",
                    got=shortened_repr(value),
                    why="What is drawn is read from the Dataset by its name.",
                    fix="Pass its name, as in 'thickness_stretch'.",
                )


def _require_kinds_of_results(argument: str, dataset: xr.Dataset) -> None:
    """Refuse variables of results that hold other things than results do."""
    for name, variable in dataset.variables.items():
        if not is_described(str(name)):
            continue
        kind = variable.dtype.kind
        is_complex = kind == "c" and name not in _COMPLEX_VARIABLES
        is_no_word = kind == "O" and not _is_of_words(variable)
        if is_complex or is_no_word or (kind in "SU" and _is_of_numbers_in_words(variable)):
            raise InputError(
                argument,
                must=f"hold {name} as results do, as real numbers or words",
                got=f"{name} of {variable.dtype}",
                why="They are drawn along axes.",
                fix="Convert it first, for example dataset.astype(float).",
            )


def _is_of_words(variable: xr.Variable) -> bool:
    """Whether entries are words, or missing as where results of different sizes are joined."""
    return all(
        isinstance(x, str) or (isinstance(x, float) and np.isnan(x)) for x in variable.values.flat
    )


def _is_of_numbers_in_words(variable: xr.Variable) -> bool:
    """Whether every entry is a number as it is written, as after ``astype(str)``."""
    try:
        variable.values.astype(np.complex128)
    except (TypeError, ValueError):
        return False
    return variable.size > 0


def _require_numbers(picture: str, given: Mapping[str, Any]) -> None:
    """Refuse a variable of words where numbers are drawn: everywhere but in charts."""
    dataset = given["dataset"]
    for name in sorted(_DRAWN_ARGUMENTS - _ARGUMENTS_OF_WORDS.get(picture, frozenset())):
        variable = given.get(name)
        if not isinstance(variable, str) or variable not in dataset:
            continue
        kind = dataset[variable].dtype
        if kind.kind in "OSU":
            raise InputError(
                name,
                must="be a variable of numbers",
                got=f"{variable!r}, which holds {kind}",
                why="Words have no place on an axis.",
                fix="Pass the name of another, as in 'thickness_stretch'.",
            )


def _require_same_dimensions(given: Mapping[str, Any]) -> None:
    """Refuse a curve through two variables that do not go together."""
    dataset = given["dataset"]
    observable = observable_name(dataset)
    usual = {"x": observable, "y": f"{observable}_rate"}
    names = [given.get(name) or word for name, word in usual.items()]
    if any(name not in dataset for name in names):
        return  # told later
    x, y = (dataset[name].dims for name in names)
    if set(x) != set(y):
        raise InputError(
            "x",
            must=f"have the dimensions of {names[1]}, {', '.join(map(str, y)) or 'none'}",
            got=f"{names[0]!r} along {', '.join(map(str, x)) or 'none'}",
            why="A curve goes through their values one by one.",
            fix="Pass two variables of the state.",
        )


def _require_plain_words(words: Mapping[str, Any]) -> None:
    """Refuse numbers among words for Matplotlib of which it would drop something."""
    for name, value in words.items():
        # Lists within lists are Matplotlib's to refuse: one may hold itself.
        entries = value if isinstance(value, list | tuple) else [value]
        dropped = next(filter(None, map(_what_matplotlib_drops, entries)), "")
        if dropped:
            raise InputError(
                name,
                must="be plain numbers",
                got=shortened_repr(value),
                why=f"Matplotlib would drop {dropped}.",
                fix="Pass the number in points, without a unit.",
            )
        size = getattr(value, "size", 0)
        if isinstance(size, int) and size > _MOST_NUMBERS_IN_A_WORD:
            raise InputError(
                name,
                must=f"be at most {_MOST_NUMBERS_IN_A_WORD} numbers",
                got=f"{size} numbers",
                why="Matplotlib copies them.",
                fix="Pass one for each artist.",
            )


def _what_matplotlib_drops(value: object) -> str:
    """What Matplotlib would drop of a number; else nothing."""
    if is_quantity(value):
        return "the unit"
    if isinstance(value, complex) or getattr(getattr(value, "dtype", None), "kind", "") == "c":
        return "the imaginary part"
    return "the mask" if isinstance(value, np.ndarray) and np.ma.is_masked(value) else ""


def _require_axes(value: object) -> None:
    if value is not None and (not isinstance(value, Axes) or hasattr(value, "get_zlim")):
        raise InputError(
            "ax",
            must="be Matplotlib axes of a plane",
            got=shortened_repr(value),
            why="The picture is drawn in them.",
            fix="Pass what plt.subplots() returns second, or leave it out for a new figure.",
        )


def _other_result_error(error: MissingVariablesError, results_of: tuple[str, ...]) -> InputError:
    """Say whose result the picture draws."""
    fix = error.fix
    if results_of:
        functions = " or ".join(f"rm.{name}" for name in results_of)
        fix = f"Pass the result of {functions}."
    fix = f"{fix.rstrip('.')}; rm.plot.overview draws what suits any result."
    return InputError(error.name, must=error.must, got=error.got, why=error.why, fix=fix)


def _unknown_words_error(words: Mapping[str, Any], title: str, error: Exception) -> InputError:
    return InputError(
        ", ".join(words),
        must=f"be an argument of {title}, or one that Matplotlib takes for what it draws",
        got=shortened_repr(dict(words)),
        why=error_sentence(error),
        fix="Check the spelling and the value.",
    )
