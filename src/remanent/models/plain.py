"""Values of a model as plain data, and back: what results and study files hold of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

import remanent
from remanent import _checks
from remanent._errors import InputError
from remanent.models.physical_sizes import PhysicalSizes
from remanent.models.scaling import Scales

__all__ = ["from_plain_data", "to_plain_data"]

#: The entry of a table that says which class the value has.
KIND_KEY: Final = "kind"
#: Classes within values that have no public name.
_NESTED_CLASSES: Final[Mapping[str, type]] = MappingProxyType(
    {"Scales": Scales, "PhysicalSizes": PhysicalSizes}
)
#: Longest part of a refused value that a message shows.
_MAX_SHOWN_LENGTH: Final = 80


def to_plain_data(value: object) -> dict[str, Any]:
    """A system, a drive or a part as a table of plain data.

    Parameters
    ----------
    value : frozen dataclass
        An :class:`~remanent.Actuator`, a drive, or any part of a model.

    Returns
    -------
    dict of str to plain data
        The name of its class as ``kind``, and its fields: numbers, text, lists, and tables
        for parts within it.  Fields that are None by default and in `value` are left out, as
        TOML has no None.  A class that is not public has the name of its module before its
        own, and :func:`from_plain_data` refuses it.

    Raises
    ------
    InputError
        A field holds something that is not plain data, such as a function.

    See Also
    --------
    from_plain_data : the way back, exact to the last bit of every number.

    Examples
    --------
    >>> from remanent import Actuator, Gent, Rayleigh
    >>> table = to_plain_data(Actuator(material=Gent(50.0), dissipation=Rayleigh(0.05)))
    >>> table["material"]
    {'kind': 'Gent', 'jm': 50.0, 'entropic_fraction': 1.0}
    >>> table["dissipation"]
    [{'kind': 'Rayleigh', 'eta': 0.05}]
    """
    if isinstance(value, type) or not is_dataclass(value):
        raise _not_plain_error("value", value)
    table: dict[str, Any] = {KIND_KEY: _kind_name(type(value))}
    # A mapping within a part is kept as pairs.
    pairs = {*getattr(value, "mapping_rules", ()), *getattr(value, "mapping_fields", ())}
    for field in _init_fields(value):
        content = getattr(value, field.name)
        if content is not None or field.default is not None:
            content = dict(content) if field.name in pairs else content
            table[field.name] = _plain_content(field.name, content)
    return table


def from_plain_data(table: Mapping[str, Any]) -> Any:
    """The value that a table of plain data describes.

    Parameters
    ----------
    table : mapping of str to plain data
        The public name of a class as ``kind``, and its fields; what is left out has its
        default.  Parts are tables too.

    Returns
    -------
    Actuator, Drive or Part
        A value of that class, checked as when it is built by hand.

    Raises
    ------
    InputError
        An unknown kind or field, a field that is missing, or a value that breaks a rule.

    See Also
    --------
    to_plain_data : the table of a value.

    Examples
    --------
    >>> from_plain_data({"kind": "SineSquared", "b": 0.4, "omega": 1.25})
    SineSquared(b=0.4, omega=1.25, phase=0.0)
    """
    kind = table.get(KIND_KEY) if isinstance(table, Mapping) else None
    cls = _class_by_kind(kind)
    if cls is None:
        raise InputError(
            KIND_KEY,
            must=f"be one of {', '.join(_public_kinds())}",
            got=_shortened(kind),
            why="A value is rebuilt by the public name of its class.",
            fix="Pass a value of a class of your own itself, as a system or a drive.",
        )
    arguments = {
        name: _rebuilt_content(content) for name, content in table.items() if name != KIND_KEY
    }
    known = [field for field in fields(cls) if field.init]
    _checks.require_known_names(arguments, [field.name for field in known], str(kind))
    for field in known:
        if _is_required(field) and field.name not in arguments:
            raise InputError(
                field.name,
                must=f"be given for {kind}",
                got="a table without it",
                why="It has no default.",
                fix=f"Add `{field.name}` to the table.",
            )
    return cls(**arguments)


def _init_fields(value: Any) -> list[Field[Any]]:
    return [field for field in fields(value) if field.init]


def _is_required(field: Field[Any]) -> bool:
    return field.default is MISSING and field.default_factory is MISSING


def _kind_name(cls: type) -> str:
    """The public name of a class, else one that no public class has."""
    name = cls.__name__
    return name if _class_by_kind(name) is cls else f"{cls.__module__}.{cls.__qualname__}"


def _class_by_kind(kind: object) -> Any:
    """The dataclass that has this name in a table; None where there is none."""
    if not isinstance(kind, str):
        return None
    if kind in _NESTED_CLASSES:
        return _NESTED_CLASSES[kind]
    value = getattr(remanent, kind, None) if kind in remanent.__all__ else None
    return value if isinstance(value, type) and is_dataclass(value) else None


def _public_kinds() -> list[str]:
    """Names of the public dataclasses; other names are not imported to find them."""
    capitalised = (name for name in remanent.__all__ if name[0].isupper())
    return sorted(name for name in capitalised if _class_by_kind(name) is not None)


def _plain_content(name: str, content: Any) -> Any:
    if isinstance(content, np.ndarray | np.generic):
        content = content.tolist()
    if content is None or isinstance(content, bool | int | float | str):
        return content
    if is_dataclass(content) and not isinstance(content, type):
        return to_plain_data(content)
    if isinstance(content, Mapping):
        return {str(key): _plain_content(name, item) for key, item in content.items()}
    if isinstance(content, tuple | list):
        return [_plain_content(name, item) for item in content]
    raise _not_plain_error(name, content)


def _rebuilt_content(content: Any) -> Any:
    if isinstance(content, Mapping):
        if KIND_KEY in content:
            return from_plain_data(content)
        return {key: _rebuilt_content(item) for key, item in content.items()}
    return tuple(map(_rebuilt_content, content)) if isinstance(content, list) else content


def _not_plain_error(name: str, content: object) -> InputError:
    return InputError(
        name,
        must="be a number, text, a part, or a list or table of these",
        got=_shortened(content),
        why="Results and study files hold plain data only.",
        fix="Write it as numbers or as a formula.",
    )


def _shortened(content: object) -> str:
    text = repr(content)
    return text if len(text) <= _MAX_SHOWN_LENGTH else f"{text[: _MAX_SHOWN_LENGTH - 1]}…"
