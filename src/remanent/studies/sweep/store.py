"""The store of a study: arrays in a folder, of which each task writes whole chunks.

Version 1 of the schema.  A folder in Zarr format 3, as ``xarray.open_zarr`` opens it:

* an array for each variable and coordinate of what the verb returns, with the names of its
  dimensions; along the grid it is cut in chunks that depend on the study alone, and every chunk
  ends with a CRC-32C checksum;
* words such as regimes are numbers with their meanings beside them; other text is text;
* nothing computed yet is NaN, -1, empty text, and 0 in ``status``;
* dimensions of lists, such as ``orbit``, are as long as the longest list so far, and
  ``<dimension>_length`` says how long the list of each point is;
* the attributes are those of the result, with the study, its digest, the schema's version, and
  what else decides numbers;
* the group ``bookkeeping`` holds a copy of the study, locks and the marks of attempts.

A task writes all other variables before it writes ``status``, so that a status other than 0 says
that the numbers are there.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from filelock import FileLock
from numpy.typing import NDArray

from remanent._errors import InputError, RemanentError
from remanent.results.atomic import atomic_replacement
from remanent.results.schema import describe
from remanent.results.stores import LENGTH_ENDING, SCHEMA_VERSION, require_readable_version
from remanent.studies.sweep.chunks import Chunking, chunking
from remanent.studies.sweep.encoding import (
    fill_value,
    stored_attributes,
    stored_dtype,
    stored_values,
)
from remanent.studies.sweep.grid import GridPart
from remanent.studies.sweep.study import Study, code_identity, study_from_plain

#: Group for what is no result.
BOOKKEEPING: Final = "bookkeeping"
#: Entries along dimensions of lists that make a chunk.
_LIST_CHUNKS: Final[Mapping[str, int]] = {
    "point": 64, "crossing": 64, "orbit": 8, "special": 8, "branch": 4, "peak": 4, "end": 2,
    "equilibrium": 4, "step": 4, "fold": 4, "snap": 2, "attractor": 4,
}  # fmt: skip
#: File with the checksum of the description.
_CHECKSUM_FILE: Final = "description.sha256"
#: Text that verbs add only where there is something to say.
_OPTIONAL: Final = "reason"
#: Seconds to wait for another process that makes an array longer.
_LOCK_SECONDS: Final = 60.0
#: Level of compression.
_ZSTD_LEVEL: Final = 3


@dataclass(frozen=True)
class Store:
    """A store on disk, with the study that it is for.

    Attributes
    ----------
    path : Path
    study : Study
    chunking : Chunking
    """

    path: Path
    study: Study
    chunking: Chunking
    _arrays: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def bookkeeping(self) -> Path:
        """The folder for what is no result."""
        return self.path / BOOKKEEPING

    @cached_property
    def grid_dims(self) -> tuple[str, ...]:
        """Names of the dimensions of the grid."""
        return self.study.grid.dims

    def array(self, name: str) -> Any:
        """The Zarr array of a variable; what is known of it is kept."""
        if name not in self._arrays:
            self._arrays[name] = _open_array(self.path / name)
        return self._arrays[name]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all arrays."""
        return tuple(sorted(name for name, _ in _open_group(self.path).arrays()))

    def write(self, part: GridPart, result: xr.Dataset) -> None:
        """Write the result of whole chunks: everything else first, the status last."""
        lengths = _list_lengths(result, self.grid_dims)
        self._make_longer(result)
        variables = {
            str(name): variable
            for name, variable in result.variables.items()
            if set(variable.dims) & set(self.grid_dims) and name not in self.grid_dims
        }
        if _OPTIONAL in self.names and _OPTIONAL not in variables:
            status = variables["status"]
            variables[_OPTIONAL] = xr.Variable(
                self.array(_OPTIONAL).metadata.dimension_names,
                np.full(self._shape_of(_OPTIONAL, part, status), "", dtype="U1"),
            )
        longest = {dim: int(array.max(initial=0)) for dim, array in lengths.items()}
        for name in sorted(variables):
            if name != "status":
                self._write_variable(name, variables[name], part, longest)
        grid_part = dict(zip(self.grid_dims, part, strict=True))
        for dim, values in lengths.items():
            self.array(f"{dim}{LENGTH_ENDING}")[tuple(grid_part.values())] = values
        self._write_variable("status", variables["status"], part, longest)

    def _shape_of(self, name: str, part: GridPart, status: xr.Variable) -> list[int]:
        sizes = {dim: s.stop - s.start for dim, s in zip(self.grid_dims, part, strict=True)}
        sizes = {**dict(zip(map(str, status.dims), status.shape, strict=True)), **sizes}
        return [sizes[dim] for dim in self.array(name).metadata.dimension_names]

    def _write_variable(
        self, name: str, variable: xr.Variable, part: GridPart, longest: Mapping[str, int]
    ) -> None:
        slices = dict(zip(self.grid_dims, part, strict=True))
        inner = {
            str(dim): slice(0, min(size, longest.get(str(dim), size)))
            for dim, size in variable.sizes.items()
            if dim not in slices
        }
        values = variable.values[tuple(inner.get(str(dim), slice(None)) for dim in variable.dims)]
        if not values.size:
            return
        places = tuple({**inner, **slices}[str(dim)] for dim in variable.dims)
        self.array(name)[places] = stored_values(name, values)

    def _make_longer(self, result: xr.Dataset) -> None:
        """Make dimensions of lists as long as this result needs."""
        if not self._is_too_short(result):
            return
        with FileLock(self.bookkeeping / "lengths.lock", timeout=_LOCK_SECONDS):
            self._arrays.clear()
            for name in map(str, result.variables):
                if name in self.names:
                    self._make_array_longer(name, result)
            seal_description(self.path)

    def _is_too_short(self, result: xr.Dataset) -> bool:
        names = (name for name in map(str, result.variables) if name in self.names)
        return any(self._missing_length(name, result) for name in names)

    def _missing_length(self, name: str, result: xr.Dataset) -> bool:
        array = self.array(name)
        return any(
            dim not in self.grid_dims and have < result.sizes[dim]
            for dim, have in zip(array.metadata.dimension_names, array.shape, strict=True)
        )

    def _make_array_longer(self, name: str, result: xr.Dataset) -> None:
        array = self.array(name)
        dims = array.metadata.dimension_names
        shape = tuple(
            have if dim in self.grid_dims else max(have, result.sizes[dim])
            for dim, have in zip(dims, array.shape, strict=True)
        )
        if shape == array.shape:
            return
        array.resize(shape)
        if not set(dims) & set(self.grid_dims):
            array[...] = stored_values(name, result.variables[name].values)

    def computed(self, chunk: tuple[int, ...]) -> bool:
        """Whether every point of a chunk has a status other than 0."""
        return bool((self.status_of(self.chunking.part_of(chunk)) != 0).all())

    def status_of(self, part: GridPart) -> NDArray[np.int8]:
        """The status of a part of the grid."""
        array = self.array("status")
        slices = dict(zip(self.grid_dims, part, strict=True))
        dims = array.metadata.dimension_names
        return np.asarray(array[tuple(slices.get(dim, slice(None)) for dim in dims)])

    def forget(self, chunk: tuple[int, ...]) -> None:
        """Say that a chunk is not computed."""
        array = self.array("status")
        slices = dict(zip(self.grid_dims, self.chunking.part_of(chunk), strict=True))
        dims = array.metadata.dimension_names
        array[tuple(slices.get(dim, slice(None)) for dim in dims)] = 0


def create_store(path: Path, study: Study, template: xr.Dataset) -> Store:
    """An empty store for a study.

    Parameters
    ----------
    path : Path
        A folder that does not exist, or is empty.
    study : Study
    template : xarray.Dataset
        What the verb gives for a part of the grid.
    """
    store = Store(path, study, chunking(study.verb, study.grid, _bytes_per_point(study, template)))
    path.mkdir(parents=True, exist_ok=True)
    write_layout(store, template)
    return store


def write_layout(store: Store, template: xr.Dataset) -> None:
    """Write what a store has before anything is computed; the study's copy comes last."""
    import zarr

    study, path = store.study, store.path
    group = zarr.create_group(str(path), zarr_format=3, overwrite=False)
    group.create_group(BOOKKEEPING)
    attributes = {
        **{str(key): value for key, value in template.attrs.items()},
        "study": study.text,
        "study_digest": study.digest,
        "schema_version": SCHEMA_VERSION,
        "coordinate_names": sorted(map(str, template.coords)),
        "has_reason": _OPTIONAL in template,
        **{f"code_{key}": value for key, value in code_identity().items()},
    }
    group.attrs.update({k: _plain(v) for k, v in attributes.items()})
    for name, variable in _all_variables(study, template).items():
        _create_array(group, store, name, variable)
    text = json.dumps({"study": study.plain, "schema_version": SCHEMA_VERSION}, ensure_ascii=False)
    with atomic_replacement(store.bookkeeping / "study.json") as file:
        file.write_text(text, encoding="utf-8")
    seal_description(path)


def open_store(path: Path) -> Store:
    """The store at a path, which may be incomplete.

    Raises
    ------
    InputError
        There is none, or it is of a newer version.
    """
    try:
        group = _open_group(path)
        attributes = dict(group.attrs)
        require_readable_version(attributes)
        study = json.loads(attributes["study"])
        chunks = dict(zip(group["status"].metadata.dimension_names, group["status"].chunks,
                          strict=True))  # fmt: skip
    except InputError:
        raise
    except Exception as error:  # what a damaged store raises is not limited
        raise InputError(
            "store",
            must="be a store of a study",
            got=str(path),
            why="There is none, or its description cannot be read.",
            fix="Check the path; `remanent verify` says what is damaged.",
        ) from error
    rebuilt = study_from_plain(study)
    shape = tuple(chunks[dim] for dim in rebuilt.grid.dims)
    return Store(path, rebuilt, Chunking(rebuilt.grid, shape))


def _open_group(path: Path) -> Any:
    import zarr

    return zarr.open_group(str(path), mode="r+", zarr_format=3, use_consolidated=False)


def _open_array(path: Path) -> Any:
    """An array of which chunks are written that hold nothing, so that a missing file is a fault."""
    import zarr

    with zarr.config.set({"array.write_empty_chunks": True}):
        return zarr.open_array(str(path), mode="r+", zarr_format=3)


def seal_description(path: Path) -> None:
    """Write one description of all arrays, which readers open at once, and its checksum."""
    import zarr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that the specification does not have it yet
        zarr.consolidate_metadata(str(path))
    with atomic_replacement(path / BOOKKEEPING / _CHECKSUM_FILE) as file:
        file.write_text(_checksum(path), encoding="utf-8")


def description_is_sound(path: Path) -> bool:
    """Whether the description of a store is as it was written."""
    try:
        expected = (path / BOOKKEEPING / _CHECKSUM_FILE).read_text(encoding="utf-8")
        whole = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        if _checksum(path) != expected:
            return False
        return all(
            _own_description(json.loads((path / name / "zarr.json").read_text(encoding="utf-8")))
            == _own_description(description)
            for name, description in whole["consolidated_metadata"]["metadata"].items()
        )
    except (OSError, ValueError, KeyError):
        return False


def _own_description(description: Mapping[str, Any]) -> dict[str, Any]:
    """What is said of an array or group itself."""
    return {k: v for k, v in description.items() if k != "consolidated_metadata"}


def _checksum(path: Path) -> str:
    """Of the description and of the copy of the study."""
    content = (path / "zarr.json").read_bytes() + (path / BOOKKEEPING / "study.json").read_bytes()
    return hashlib.sha256(content).hexdigest()


def _all_variables(study: Study, template: xr.Dataset) -> dict[str, xr.Variable]:
    """All arrays of a store, with the values that all points share; along the grid only a part."""
    grid = study.grid
    variables = {str(name): variable for name, variable in template.variables.items()}
    status = variables["status"]
    if _OPTIONAL not in variables:
        along_grid = [dim for dim in status.dims if dim in grid.dims]
        nothing = np.full([status.sizes[dim] for dim in along_grid], "")
        variables[_OPTIONAL] = xr.Variable(along_grid, nothing, _reason_attributes())
    for dim in _list_dims(template, grid.dims):
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
            (grid if is_known else grid_chunks).get(dim, _LIST_CHUNKS.get(dim, max(sizes[dim], 1)))
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


def _list_dims(result: xr.Dataset, grid_dims: Sequence[str]) -> list[str]:
    return sorted(
        str(dim) for dim in result.dims if dim not in grid_dims and str(dim) in _LIST_CHUNKS
    )


def _list_lengths(result: xr.Dataset, grid_dims: Sequence[str]) -> dict[str, NDArray[np.int32]]:
    """How many entries the list of each point has: up to the last that says something."""
    shape = [result.sizes[dim] for dim in grid_dims]
    lengths: dict[str, NDArray[np.int32]] = {}
    for dim in _list_dims(result, grid_dims):
        length = np.zeros(shape, dtype=np.int32)
        for variable in result.data_vars.values():
            if dim in variable.dims and set(variable.dims) & set(grid_dims):
                length = np.maximum(length, _lengths_by(variable.variable, dim, grid_dims, shape))
        lengths[dim] = length
    return lengths


def _lengths_by(
    variable: xr.Variable, dim: str, grid_dims: Sequence[str], shape: Sequence[int]
) -> NDArray[np.int32]:
    """The length of the list of each point by one of its variables."""
    if not variable.sizes[dim]:
        return np.zeros(shape, dtype=np.int32)
    values = variable.values
    nothing = "" if values.dtype.kind in "UTO" else fill_value("", values.dtype)
    said = xr.Variable(
        variable.dims, ~np.isnan(values) if values.dtype.kind in "fc" else values != nothing
    )
    numbers = xr.Variable((dim,), np.arange(1, variable.sizes[dim] + 1, dtype=np.int32))
    present = [d for d in grid_dims if d in variable.dims]
    further = [d for d in variable.dims if d not in present]
    table = (said * numbers).transpose(*present, *further).values
    last = table.max(axis=tuple(range(len(present), table.ndim)), initial=0)
    index = tuple(slice(None) if d in present else np.newaxis for d in grid_dims)
    return np.broadcast_to(last[index], shape).astype(np.int32)


def _reason_attributes() -> dict[str, str]:
    return describe(_OPTIONAL).attributes()


def _bytes_per_point(study: Study, template: xr.Dataset) -> int:
    """Bytes of the largest variable for one point of the grid."""
    points = max(int(np.prod([template.sizes.get(dim, 1) for dim in study.grid.dims])), 1)
    sizes = (v.nbytes for v in template.data_vars.values() if set(v.dims) & set(study.grid.dims))
    return max(sizes, default=8) // points


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def partial_files(path: Path) -> Iterable[Path]:
    """Files that a process was writing when it was killed."""
    return path.rglob("*.partial")


def require_same(store: Store, study: Study) -> None:
    """Refuse to go on with another study, or with other code.

    Raises
    ------
    InputError, RemanentError
        Saying what differs.
    """
    if store.study.digest != study.digest:
        old, new = store.study.plain, study.plain
        changed = sorted(key for key in {*old, *new} if old.get(key) != new.get(key))
        raise InputError(
            "store",
            must="be of this study",
            got=f"one with another {', '.join(changed)}",
            why="A store holds the results of one study.",
            fix="Pass another place for the results, or the study as it was.",
        )
    attributes = dict(_open_group(store.path).attrs)
    changes = [
        f"{key} was {attributes.get(f'code_{key}')}, is {value}"
        for key, value in code_identity().items()
        if attributes.get(f"code_{key}") != value
    ]
    if changes:
        raise RemanentError(
            f"the store {store.path} was begun by other code, which may give other numbers: "
            f"{'; '.join(changes)}. Go on where it was begun, or pass another place."
        )
