"""The Field of a system and a drive: from the cache, or else derived."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Final

from remanent import _cache
from remanent._errors import InputError
from remanent._field import Field
from remanent.models.drives.base import Drive
from remanent.models.parts import EquationStructure
from remanent.models.system import System

#: The family of entries in the cache.
_CACHE_KIND: Final = "fields"
#: Fields by the fingerprint of their structure.
_fields_by_fingerprint: Final[dict[str, Field]] = {}


def vector_field_for(system: System, drive: Drive) -> Field:
    """The vector field of a system under a drive, with what is observed of it.

    Only the form of the equations matters, never a number: the numeric fields of both
    are the parameters of the field, in the order of ``system.parameter_values()``,
    ``drive.parameter_values()`` and ``drive.piece_parameter_names``.  SymPy is imported only if
    the field is neither in memory nor in the cache.

    Raises
    ------
    InputError
        Where the drive does not give the loads that the system has.
    """
    if system.load_names != drive.load_names:
        raise InputError(
            "drive",
            must=f"give the loads of the system: {', '.join(system.load_names)}",
            got=", ".join(drive.load_names),
            why="Every load in the equations of motion needs a law in time.",
            fix="Pass a drive for each load.",
        )
    structure = (system.equation_structure(), drive.equation_structure())
    if not _has_only_own_classes(structure):
        return _derive_field(system, drive)
    key = structure_fingerprint(structure)
    if key not in _fields_by_fingerprint:
        _fields_by_fingerprint[key] = _load_from_cache(key) or _store_in_cache(
            key, _derive_field(system, drive)
        )
    return _fields_by_fingerprint[key]


def structure_fingerprint(structure: EquationStructure) -> str:
    """A digest of what a field depends on: the structure and this package's code."""
    text = json.dumps([structure, *_version_and_source_digest()])
    return hashlib.sha256(text.encode()).hexdigest()


def _derive_field(system: System, drive: Drive) -> Field:
    """The field by derivation, which imports SymPy."""
    field: Field = import_module("remanent.codegen.build").build_field(system, drive)
    return field


def _load_from_cache(key: str) -> Field | None:
    """The field from the cache on disk, or None where there is none that can be read."""
    text = _cache.load_text(_CACHE_KIND, key)
    if text is not None:
        with suppress(ValueError):
            return Field.from_json(text)
    return None


def _store_in_cache(key: str, field: Field) -> Field:
    """The field itself, after writing it to the cache on disk."""
    _cache.store_text(_CACHE_KIND, key, field.to_json())
    return field


def _has_only_own_classes(structure: EquationStructure) -> bool:
    """Whether every class in `structure` is this package's; others may change unseen."""
    return all(name.startswith("remanent.") for name in _class_names(structure))


def _class_names(structure: EquationStructure) -> Iterator[str]:
    for item in structure:
        if isinstance(item, tuple):
            yield from _class_names(item)
        elif isinstance(item, str) and ":" in item:
            yield item


@cache
def _version_and_source_digest() -> tuple[str, str]:
    """Version of the package, and a digest of the code that makes fields."""
    digest = _cache.source_digest(
        "_field.py", "_instructions.py", "models", "derivation", "codegen"
    )
    try:
        return version("remanent"), digest
    except PackageNotFoundError:
        return "not installed", digest
