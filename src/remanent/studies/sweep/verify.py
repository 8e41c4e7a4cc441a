"""Whether a store is whole: every number that should be there can be read, and none is damaged."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from remanent._errors import InputError, RemanentError
from remanent.results.stores import BOOKKEEPING, LENGTH_ENDING, require_readable_version
from remanent.studies.sweep.store import Store, description_is_sound, open_store
from remanent.studies.sweep.study import Study, study_from_plain


class Integrity(IntEnum):
    """What a store is; the values are exit codes."""

    WHOLE = 0
    DAMAGED = 1
    INCOMPLETE = 3


@dataclass(frozen=True)
class Findings:
    """What is wrong with a store.

    Attributes
    ----------
    description : str
        What is wrong with the description of the store and with what all points share; empty where
        nothing is.
    damaged, missing : tuple of chunks
        Chunks that cannot be read, though they were computed, and chunks that were not.
    chunk_count : int
        Chunks of the store.
    """

    description: str
    damaged: tuple[tuple[int, ...], ...]
    missing: tuple[tuple[int, ...], ...]
    chunk_count: int

    @property
    def integrity(self) -> Integrity:
        """The worst of what was found."""
        if self.description or self.damaged:
            return Integrity.DAMAGED
        return Integrity.INCOMPLETE if self.missing else Integrity.WHOLE

    @property
    def text(self) -> str:
        """What was found, for people."""
        if self.integrity is Integrity.WHOLE:
            return f"whole and complete: {self.chunk_count} of {self.chunk_count} chunks"
        parts = [self.description] if self.description else []
        if self.damaged:
            parts.append(f"{len(self.damaged)} of {self.chunk_count} chunks are damaged")
        if self.missing:
            parts.append(f"{len(self.missing)} of {self.chunk_count} chunks are not computed")
        return "; ".join(parts)


def verify_store(path: Path) -> Findings:
    """Read everything that a store should have, and say what is damaged and what is missing.

    Raises
    ------
    InputError
        There is no store, or one of a newer version.
    """
    _require_readable(path)
    study = study_of_store(path)
    if not description_is_sound(path):
        return Findings(_DAMAGED_DESCRIPTION, (), (), 0)
    store = open_store(path)
    if store.study.digest != study.digest:
        return Findings(_DAMAGED_DESCRIPTION, (), (), 0)
    problem = _problem_of_shared(store)
    damaged, missing = [], []
    for chunk in store.chunking.chunks():
        try:
            complete = store.computed(chunk)
            if complete:
                _read_chunk(store, chunk)
            else:
                missing.append(chunk)
        except _DAMAGES:
            damaged.append(chunk)
    return Findings(problem, tuple(damaged), tuple(missing), store.chunking.chunk_count)


_DAMAGED_DESCRIPTION = "its description is damaged"
#: What readers raise of damaged chunks: wrong checksums, sizes, codes, and missing files.
_DAMAGES = (ValueError, TypeError, OSError, RuntimeError, KeyError, RemanentError)


def _require_readable(path: Path) -> None:
    """Refuse a store whose description says that it is of a newer version."""
    try:
        attributes = json.loads((path / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        version = int(attributes["schema_version"])
    except (OSError, ValueError, KeyError, TypeError):
        return  # a damaged description
    require_readable_version({**attributes, "schema_version": version})


def study_of_store(path: Path) -> Study:
    """The study of a store, by the copy that its bookkeeping has, or by its description."""
    for read in (_said_by_copy, _said_by_description):
        try:
            plain, digest, _ = read(path)
            study = study_from_plain(plain)
        except Exception:  # whatever a damaged file leads to, the other one is tried
            continue
        if study.digest == digest:
            return study
    raise InputError(
        "store",
        must="be a store of a study",
        got=str(path),
        why="There is none, or nothing sound in it says which study it is of.",
        fix="Check the path.",
    )


def code_of_store(path: Path) -> dict[str, str]:
    """What computed the numbers of a store, as far as one of its two descriptions can be read."""
    for read in (_said_by_description, _said_by_copy):
        with suppress(Exception):  # as above
            return read(path)[2]
    return {}


def _said_by_copy(path: Path) -> tuple[Any, str, dict[str, str]]:
    """The study, its digest and the code, as the bookkeeping has them."""
    said = json.loads((path / BOOKKEEPING / "study.json").read_text(encoding="utf-8"))
    return said["study"], said["study_digest"], dict(said["code"])


def _said_by_description(path: Path) -> tuple[Any, str, dict[str, str]]:
    said = json.loads((path / "zarr.json").read_text(encoding="utf-8"))["attributes"]
    code = {key.removeprefix("code_"): said[key] for key in said if key.startswith("code_")}
    return json.loads(said["study"]), said["study_digest"], code


def _problem_of_shared(store: Store) -> str:
    """What is wrong with what all points share; empty where nothing is."""
    for name in store.names:
        array = store.array(name)
        dims = array.metadata.dimension_names
        if name in store.study.grid.fields.arrays or not set(dims) & set(store.grid_dims):
            sizes = zip(array.shape, array.chunks, strict=True)
            try:
                _require_files(store, name, [range(math.ceil(n / step)) for n, step in sizes])
                values = np.asarray(array[...])
            except _DAMAGES:
                return f"`{name}` is damaged"
            fields = store.study.grid.fields.arrays
            if name in fields and not np.array_equal(values, fields[name][1], equal_nan=True):
                return f"`{name}` is not that of the study"
    return ""


def _read_chunk(store: Store, chunk: tuple[int, ...]) -> None:
    """Read every variable of a chunk; its files must be there."""
    part = store.chunking.part_of(chunk)
    slices = dict(zip(store.grid_dims, part, strict=True))
    indices = dict(zip(store.grid_dims, chunk, strict=True))
    lengths = {
        name.removesuffix(LENGTH_ENDING): int(np.max(_read(store, name, slices, {}), initial=0))
        for name in store.length_names
    }
    for name in store.names:
        array = store.array(name)
        dims = array.metadata.dimension_names
        if not set(dims) & set(slices) or name in store.study.grid.fields.arrays or name in slices:
            continue
        needed = [
            range(indices[dim], indices[dim] + 1)
            if dim in indices
            else range(math.ceil(lengths.get(dim, size) / step))
            for dim, size, step in zip(dims, array.shape, array.chunks, strict=True)
        ]
        _require_files(store, name, needed)
        _read(store, name, slices, lengths)


def _read(
    store: Store, name: str, slices: dict[str, slice], lengths: dict[str, int]
) -> np.ndarray[tuple[int, ...], np.dtype[np.generic]]:
    array = store.array(name)
    dims = array.metadata.dimension_names
    places = tuple(slices.get(dim, slice(0, lengths.get(dim))) for dim in dims)
    return np.asarray(array[places])


def _require_files(store: Store, name: str, needed: list[range]) -> None:
    """Raise where the file of a chunk is missing, which would be read as nothing computed."""
    for file in _chunk_files(store, name, needed):
        if not file.is_file():
            raise FileNotFoundError(file)


def _chunk_files(store: Store, name: str, needed: list[range]) -> Iterator[Path]:
    key = store.array(name).metadata.encode_chunk_key
    return (store.path / name / key(index) for index in product(*needed))
