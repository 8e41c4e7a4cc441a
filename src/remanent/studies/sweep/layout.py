"""What a store has before anything is computed: its arrays, their chunks, and the study."""

from __future__ import annotations

import json
import os
import re
import uuid
from collections import Counter
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent._errors import InputError, shortened_repr
from remanent.results.atomic import atomic_replacement
from remanent.results.schema import describe
from remanent.results.stores import BOOKKEEPING, LENGTH_ENDING, SCHEMA_VERSION
from remanent.studies.sweep.chunks import chunking
from remanent.studies.sweep.encoding import (
    fill_value,
    plain_attribute,
    stored_attributes,
    stored_dtype,
    stored_values,
)
from remanent.studies.sweep.lists import LIST_CHUNKS, list_dims
from remanent.studies.sweep.sample import Sample
from remanent.studies.sweep.store import (
    IDENTITY_FILE,
    OPTIONAL,
    Store,
    seal_description,
)
from remanent.studies.sweep.study import Study, code_identity

#: Level of compression.
_ZSTD_LEVEL: Final = 3


def create_store(path: Path, study: Study, sample: Sample) -> Store:
    """An empty store for a study.

    Parameters
    ----------
    path : Path
        A folder that does not exist, or is empty.
    study : Study
    sample : Sample
        What the verb gives for a part of the grid.
    """
    template = sample.result
    _require_storable_names(path, {*map(str, template.variables), *map(str, template.dims)})
    store = Store(path, study, chunking(study, _bytes_per_point(study, template)))
    path.mkdir(parents=True, exist_ok=True)
    _write_layout(store, sample)
    return store


def _write_layout(store: Store, sample: Sample) -> None:
    """Write what a store has before anything is computed; the study's copy comes last."""
    import zarr

    study, path, template = store.study, store.path, sample.result
    group = zarr.create_group(str(path), zarr_format=3, overwrite=False)
    group.create_group(BOOKKEEPING)
    (store.bookkeeping / IDENTITY_FILE).write_text(uuid.uuid4().hex, encoding="utf-8")
    attributes = {
        **{str(key): value for key, value in template.attrs.items()},
        "study": study.text,
        "study_digest": study.digest,
        "schema_version": SCHEMA_VERSION,
        "coordinate_names": list(map(str, template.coords)),
        "variable_names": list(map(str, template.data_vars)),
        "has_reason": OPTIONAL in template,
        "list_dimensions": list_dims(template, study.grid.dims),
        "sample_point": [axis.start for axis in sample.part],
        **{f"code_{key}": value for key, value in code_identity().items()},
    }
    group.attrs.update({k: plain_attribute(v) for k, v in attributes.items()})
    for name, variable in _all_variables(study, template).items():
        _create_array(group, store, name, variable)
    text = json.dumps(
        {
            "study": study.plain,
            "study_digest": study.digest,
            "schema_version": SCHEMA_VERSION,
            "code": code_identity(),
        },
        ensure_ascii=False,
    )
    with atomic_replacement(store.bookkeeping / "study.json") as file:
        file.write_text(text, encoding="utf-8")
    seal_description(path)


#: Names that Windows keeps for devices, signs that it refuses, and ends that it drops.
_REFUSED_BY_WINDOWS: Final = re.compile(
    r"^(con|prn|aux|nul|com[0-9]|lpt[0-9])(\.|$)|[<>:\"|?*\x00-\x1f]|[. ]$", re.IGNORECASE
)


def unstorable_names(names: set[str], *, on_windows: bool, ignores_case: bool) -> list[str]:
    """Names that cannot be those of folders in a store.

    Parameters
    ----------
    names : set of str
        Names of variables.
    on_windows : bool
        Whether names that Windows keeps for devices, and its signs, count too.
    ignores_case : bool
        Whether names count that differ from another one in capitals alone.
    """
    taken = Counter(name.casefold() for name in names)
    return sorted(
        name
        for name in names
        if name in (BOOKKEEPING, "zarr.json")
        or set("/\\") & set(name)
        or name.startswith(".")
        or (on_windows and _REFUSED_BY_WINDOWS.search(name))
        or (ignores_case and taken[name.casefold()] > 1)
    )


def _ignores_case(folder: Path) -> bool:
    """Whether the file system takes capitals for small letters, by a folder that is there."""
    for there in (folder.resolve(), *folder.resolve().parents):
        other = there.parent / there.name.swapcase()
        if there.exists() and other.name != there.name:
            return other.exists() and other.samefile(there)
    return False


def _require_storable_names(path: Path, names: set[str]) -> None:
    """Refuse names that are no folders of a store, before anything of it is written."""
    bad = unstorable_names(names, on_windows=os.name == "nt", ignores_case=_ignores_case(path))
    if bad:
        raise InputError(
            "store",
            must="be of results whose names can be those of folders",
            got=shortened_repr(bad),
            why=f"A store has a folder for each variable, and keeps {BOOKKEEPING!r} for itself; "
            "this system has no such folder, or cannot tell it from another.",
            fix="Rename what has this name, or leave out the store.",
        )


def _all_variables(study: Study, template: xr.Dataset) -> dict[str, xr.Variable]:
    """All arrays of a store, with the values that all points share; along the grid only a part."""
    grid = study.grid
    variables = {str(name): variable for name, variable in template.variables.items()}
    status = variables["status"]
    if OPTIONAL not in variables:
        along_grid = [dim for dim in status.dims if dim in grid.dims]
        nothing = np.full([status.sizes[dim] for dim in along_grid], "")
        variables[OPTIONAL] = xr.Variable(along_grid, nothing, describe(OPTIONAL).attributes())
    for dim in list_dims(template, grid.dims):
        variables[f"{dim}{LENGTH_ENDING}"] = xr.Variable(
            grid.dims,
            np.zeros([1] * len(grid.dims), dtype=np.int32),
            {"units": "1", "long_name": f"entries along {dim}", "symbol": ""},
        )
    for name, (dims, values) in {**grid.fields.arrays, **grid.fields.labels}.items():
        if name in variables or name in grid.dims:
            attributes = variables[name].attrs if name in variables else {}
            variables[name] = xr.Variable(dims, values, attributes)
    return variables


def _create_array(group: Any, store: Store, name: str, variable: xr.Variable) -> None:
    from zarr.codecs import Crc32cCodec, ZstdCodec

    grid = dict(zip(store.grid_dims, store.study.grid.shape, strict=True))
    grid_chunks = dict(zip(store.grid_dims, store.chunking.shape, strict=True))
    dims = tuple(map(str, variable.dims))
    is_known = name in store.study.grid.fields.arrays or not set(dims) & set(grid)
    is_known = is_known or name in grid
    sizes = {str(dim): size for dim, size in variable.sizes.items()}
    array = group.create_array(
        name,
        shape=tuple(grid.get(dim, sizes[dim]) for dim in dims),
        chunks=tuple(
            (grid if is_known else grid_chunks).get(dim, LIST_CHUNKS.get(dim, max(sizes[dim], 1)))
            for dim in dims
        ),
        dtype=stored_dtype(name, variable.dtype),
        fill_value=fill_value(name, variable.dtype),
        compressors=[ZstdCodec(level=_ZSTD_LEVEL), Crc32cCodec()],
        dimension_names=dims,
        attributes=stored_attributes(name, variable),
        config={"write_empty_chunks": True},
    )
    if is_known and variable.size:
        array[...] = stored_values(name, variable.values)


def _bytes_per_point(study: Study, template: xr.Dataset) -> int:
    """Bytes of the largest variable for one point of the grid."""
    points = max(int(np.prod([template.sizes.get(dim, 1) for dim in study.grid.dims])), 1)
    sizes = (v.nbytes for v in template.data_vars.values() if set(v.dims) & set(study.grid.dims))
    return max(sizes, default=8) // points
