"""The line under a figure: which actuator, drive, tolerance and version made it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator

import xarray as xr
from matplotlib.figure import Figure

from remanent._errors import InputError
from remanent.plots.style import FAINT, number, title
from remanent.results.schema import describe

__all__ = ["add", "text"]

#: Fields that say nothing at this value.
_NEUTRAL = {
    "entropic_fraction": 1.0,
    "temperature_coefficient": 0.0,
    "phase": 0.0,
    "mean": 0.0,
    "heat": None,
    "discard": 0.0,
    "every": 1,
    "section_phase": 0.0,
}
#: Fields that may be two numbers, each with a name of its own.
_PAIRS = frozenset({"prestress", "edges"})
_SEPARATOR = "   "
_POINTS, _WIDTH = 6.0, 0.43  # font size; width of a letter in units of it, on average


def add(figure: Figure, dataset: xr.Dataset, *, hide: Iterable[str] = ()) -> None:
    """Write the footer below everything else in a figure.

    Parameters
    ----------
    figure
        A figure with constrained layout, which makes room for it.
    dataset
        The result that was drawn.
    hide
        Fields that took many values on the way to what is drawn; ``"drive"`` leaves
        the whole drive out.
    """
    found = text(dataset, hide=hide)
    if found:
        letters = figure.get_figwidth() * 72.0 / (_POINTS * _WIDTH)
        figure.supxlabel(
            _wrap(found, letters), x=0.01, ha="left", fontsize=_POINTS, color=FAINT, linespacing=1.3
        )


def text(dataset: xr.Dataset, *, hide: Iterable[str] = ()) -> str:
    """Return the footer: parameters that the picture does not show, settings, tolerance, version.

    Parameters
    ----------
    dataset
        A result with the attributes of :mod:`remanent.results.provenance`.
    hide
        As in :func:`add`.

    Returns
    -------
    str
        Pieces parted by three blanks; empty without provenance.
    """
    attrs = dataset.attrs
    given = [*map(str, dataset.coords), *str(attrs.get("over", "")).split()]
    shown = {name.split(".")[-1] for name in [*given, *hide]}
    drive = "" if "drive" in shown else str(attrs.get("drive", ""))
    single = [array for array in dataset.coords.values() if array.ndim == 0]
    settings = str(attrs.get("settings", "")).split()
    pieces = [
        *(title(array, array.item()) for array in single),
        *_call(str(attrs.get("actuator", "")), shown, name_it=False),
        *_call(drive, shown, name_it=True),
        *(_setting(key, attrs[key]) for key in settings if not _neutral(key, attrs[key])),
    ]
    if "tolerance" in attrs and "tolerance" not in dataset.dims:
        pieces.append(f"tolerance ${number(attrs['tolerance'])}$")
    version = re.search(r"remanent \d[^,]*", str(attrs.get("versions", "")))
    return _SEPARATOR.join([*pieces, version[0] if version else ""]).strip()


def _call(source: str, shown: set[str], *, name_it: bool) -> list[str]:
    """Say a ``repr`` in symbols: the number fields by symbol, the parts by name."""
    if not source:
        return []
    try:
        tree = ast.parse(source, mode="eval").body
    except SyntaxError:
        return [_short(source)]
    if not isinstance(tree, ast.Call):
        return [_short(source)]
    said = [*_fields(tree, shown)]
    name = ast.unparse(tree.func)
    return [f"{name}: {', '.join(said)}" if said else name] if name_it else said


def _fields(tree: ast.Call, shown: set[str], owner: str = "") -> Iterator[str]:
    for keyword in tree.keywords:
        name = str(keyword.arg)
        if isinstance(keyword.value, ast.Call):
            yield from _part(keyword.value, shown, name)
            continue
        if isinstance(keyword.value, (ast.Tuple, ast.List)):
            for k, item in enumerate(keyword.value.elts):
                if isinstance(item, ast.Call):
                    yield from _part(item, shown, f"{name}.{k}")
                elif name in _PAIRS and f"{name}_{k + 1}" not in shown:
                    yield _setting(f"{name}_{k + 1}", ast.literal_eval(item))
            continue
        try:
            value = ast.literal_eval(keyword.value)
        except ValueError:
            continue
        if name in shown or _neutral(name, value):
            continue
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            yield _setting(f"{owner}.{name}" if owner else name, value)


def _neutral(name: str, value: object) -> bool:
    return name in _NEUTRAL and value == _NEUTRAL[name]


def _part(tree: ast.Call, shown: set[str], owner: str) -> Iterator[str]:
    name, said = ast.unparse(tree.func), list(_fields(tree, shown, owner))
    if said or name != "Magnet":
        yield f"{name} ({', '.join(said)})" if said else name


def _setting(name: str, value: object) -> str:
    if not isinstance(value, (int, float)):
        return f"{name.replace('_', ' ')} {value}"
    try:
        row = describe(name)
    except InputError:
        return f"{name.replace('_', ' ')} ${number(value)}$"
    unit = f" {row.units}" if row.units == "K" else ""
    return f"${row.symbol} = {number(value)}${unit}"


def _short(source: str, limit: int = 90) -> str:
    flat = " ".join(source.split()).replace("$", r"\$")
    return flat if len(flat) <= limit else f"{flat[: limit - 1]}…"


def _wrap(found: str, letters: float) -> str:
    """Break between pieces where a line would be longer than the figure."""
    lines = [""]
    for piece in found.split(_SEPARATOR):
        longer = f"{lines[-1]}{_SEPARATOR}{piece}".strip()
        if lines[-1] and _length(longer) > letters:
            lines.append(piece)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def _length(found: str) -> int:
    """Letters once typeset, roughly: a LaTeX command counts as one."""
    return len(re.sub(r"\\mathrm|[${}^_]", "", re.sub(r"\\(?!mathrm)[A-Za-z]+", "x", found)))
