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
import threading
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from filelock import FileLock
from numpy.typing import NDArray

from remanent._errors import InputError, RemanentError
from remanent._extras import require_extra
from remanent.results.atomic import atomic_replacement
from remanent.results.stores import (
    BOOKKEEPING,
    LENGTH_ENDING,
    LENGTHENING_FILE,
    require_readable_version,
)
from remanent.studies.sweep.chunks import Chunking
from remanent.studies.sweep.encoding import stored_values
from remanent.studies.sweep.grid import GridPart
from remanent.studies.sweep.lists import list_lengths
from remanent.studies.sweep.study import (
    Study,
    code_identity,
    study_from_plain,
)

#: File with the checksum of the description.
_CHECKSUM_FILE: Final = "description.sha256"
#: File with the name of a store that no other has, also not one that takes its place.
IDENTITY_FILE: Final = "identity"
#: Text that verbs add only where there is something to say.
OPTIONAL: Final = "reason"
#: Held while an array is opened, since what Zarr is told then holds for all threads.
_OPENING: Final = threading.Lock()
#: Seconds to wait for another process that makes an array longer.
_LOCK_SECONDS: Final = 60.0


@dataclass(frozen=True)
class Store:
    """A store on disk, with the study that it is for.

    Attributes
    ----------
    path : Path
    study : Study
    chunking : Chunking
    identity : str
        What no other store has.
    """

    path: Path
    study: Study
    chunking: Chunking
    identity: str = ""
    _arrays: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    _shared: dict[str, NDArray[Any]] = field(default_factory=dict, repr=False, compare=False)

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

    @cached_property
    def length_names(self) -> tuple[str, ...]:
        """Names of the arrays that say how long the lists of each point are."""
        dims = _open_group(self.path).attrs["list_dimensions"]
        return tuple(f"{dim}{LENGTH_ENDING}" for dim in dims)

    @property
    def sampled_part(self) -> GridPart:
        """A part of the grid that was computed before the store was made."""
        places = _open_group(self.path).attrs["sample_point"]
        if self.study.needs_whole_grid:
            return self.study.grid.whole
        return tuple(slice(k, k + 1) for k in places)

    def write(self, part: GridPart, result: xr.Dataset) -> None:
        """Write the result of whole chunks: everything else first, the status last.

        Raises
        ------
        RemanentError
            The result does not fit, or another store has taken the place of this one.
        """
        self._require_same_shared(result)
        self._require_in_place()
        lengths = list_lengths(result, self.grid_dims)
        self._make_longer(result)
        variables = {
            str(name): variable
            for name, variable in result.variables.items()
            if set(variable.dims) & set(self.grid_dims) and name not in self.grid_dims
        }
        if OPTIONAL in self.names and OPTIONAL not in variables:
            status = variables["status"]
            variables[OPTIONAL] = xr.Variable(
                self.array(OPTIONAL).metadata.dimension_names,
                np.full(self._shape_of(OPTIONAL, part, status), "", dtype="U1"),
            )
        longest = {dim: int(array.max(initial=0)) for dim, array in lengths.items()}
        for name in sorted(variables):
            if name != "status":
                self._write_variable(name, variables[name], part, longest)
        for dim, values in lengths.items():
            self.array(f"{dim}{LENGTH_ENDING}")[part] = values
        self._require_in_place()
        self._write_variable("status", variables["status"], part, longest)

    def _require_in_place(self) -> None:
        """Refuse to write where another store was made since this one was opened."""
        if _identity_of(self.path) != self.identity:
            raise RemanentError(
                f"The store {self.path} was removed or replaced while it was being written. "
                "Start the run again; it goes on from what is there."
            )

    def _require_same_shared(self, result: xr.Dataset) -> None:
        """Refuse a result whose points share something else than those before them."""
        for name, variable in result.variables.items():
            if name not in self.names or name in self.grid_dims:
                continue
            dims = self.array(str(name)).metadata.dimension_names
            if set(dims) != set(variable.dims):
                raise _misfit_error(str(name))
            if set(dims) & set(self.grid_dims):
                continue
            new = stored_values(str(name), variable.transpose(*dims).values)
            old = self._shared_values(str(name))
            common = tuple(map(slice, map(min, new.shape, old.shape)))
            is_float = new.dtype.kind in "fc"
            if not np.array_equal(new[common], old[common], equal_nan=is_float):
                raise _misfit_error(str(name))

    def _shared_values(self, name: str) -> NDArray[Any]:
        """Values that all points share; they are read once."""
        if name not in self._shared:
            self._shared[name] = np.asarray(self.array(name)[...])
        return self._shared[name]

    def _shape_of(self, name: str, part: GridPart, status: xr.Variable) -> list[int]:
        sizes = {dim: s.stop - s.start for dim, s in zip(self.grid_dims, part, strict=True)}
        sizes = {**dict(zip(map(str, status.dims), status.shape, strict=True)), **sizes}
        return [sizes[dim] for dim in self.array(name).metadata.dimension_names]

    def place_of(self, name: str, part: GridPart) -> tuple[slice, ...]:
        """Where the values of a part of the grid are in an array."""
        slices = dict(zip(self.grid_dims, part, strict=True))
        dims = self.array(name).metadata.dimension_names
        return tuple(slices.get(dim, slice(None)) for dim in dims)

    def _write_variable(
        self, name: str, variable: xr.Variable, part: GridPart, longest: Mapping[str, int]
    ) -> None:
        variable = variable.transpose(*self.array(name).metadata.dimension_names)
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
            self._shared.clear()
            self._lengthening.touch()
            for name in map(str, result.variables):
                if name in self.names:
                    self._make_array_longer(name, result)
            seal_description(self.path)
            self._lengthening.unlink()

    @property
    def _lengthening(self) -> Path:
        return self.bookkeeping / LENGTHENING_FILE

    def finish_lengthening(self) -> None:
        """Go on with what a process began that was killed while it made arrays longer."""
        with FileLock(self.bookkeeping / "lengths.lock", timeout=_LOCK_SECONDS):
            if not self._lengthening.exists():
                return
            arrays = {name: self.array(name) for name in self.names}
            longest: dict[str, int] = {}
            for array in arrays.values():
                for dim, size in zip(array.metadata.dimension_names, array.shape, strict=True):
                    longest[dim] = max(longest.get(dim, 0), size)
            for name, array in arrays.items():
                dims = array.metadata.dimension_names
                array.resize(tuple(longest[dim] for dim in dims))
                if dims == (name,) and name not in self.grid_dims:
                    array[...] = np.arange(longest[name])
            self._arrays.clear()
            seal_description(self.path)
            self._lengthening.unlink()

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
        try:
            return np.asarray(self.array("status")[self.place_of("status", part)])
        except (ValueError, OSError, RuntimeError) as error:
            raise RemanentError(
                f"The status of some points is damaged in {self.path}. "
                f"Compute them again with `remanent verify {self.path} --repair`."
            ) from error

    def forget(self, chunk: tuple[int, ...]) -> None:
        """Say that a chunk is not computed."""
        self.array("status")[self.place_of("status", self.chunking.part_of(chunk))] = 0


def open_store(path: Path) -> Store:
    """The store at a path, which may be incomplete.

    Raises
    ------
    InputError
        There is none, or it is of a newer version.
    RemanentError
        What reads stores is not installed.
    """
    require_extra("studies", "a store")
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
    return Store(path, rebuilt, Chunking(rebuilt.grid, shape), _identity_of(path))


def _identity_of(path: Path) -> str:
    """What was written when the store was made; empty where there is none, or not any more."""
    try:
        return (path / BOOKKEEPING / IDENTITY_FILE).read_text(encoding="utf-8")
    except OSError:
        return ""


def _misfit_error(name: str) -> RemanentError:
    return RemanentError(
        f"`{name}` differs between points of the grid that were computed apart, so that one store "
        "cannot hold it. Call the verb for the whole grid, and report this as a fault of remanent."
    )


def _open_group(path: Path) -> Any:
    import zarr

    return zarr.open_group(str(path), mode="r", zarr_format=3, use_consolidated=False)


def _open_array(path: Path) -> Any:
    """An array of which chunks are written that hold nothing, so that a missing file is a fault."""
    import zarr

    with _OPENING, zarr.config.set({"array.write_empty_chunks": True}):
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


def partial_files(path: Path) -> Iterable[Path]:
    """Files that a process was writing when it was killed."""
    return path.rglob("*.partial")


def is_store_of_study(path: Path) -> bool:
    """Whether a store was made there to the end, whatever became of it."""
    return (path / BOOKKEEPING / _CHECKSUM_FILE).exists()


def was_only_begun(path: Path) -> bool:
    """Whether a folder holds a store of ours that nothing was written to, not even its end."""
    names = {entry.name for entry in path.iterdir()}
    if names <= {"zarr.json", BOOKKEEPING}:
        return "zarr.json" in names
    is_ours = (path / BOOKKEEPING / IDENTITY_FILE).exists()
    return is_ours and not is_store_of_study(path) and not (path / "status" / "c").exists()


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
        changed = changed or ["order of dimensions"]
        raise InputError(
            "store",
            must="be of this study",
            got=f"one with another {', '.join(changed)}",
            why="A store holds the results of one study.",
            fix="Pass another place for the results, or the study as it was.",
        )
    attributes = dict(_open_group(store.path).attrs)
    begun_by = {key: str(attributes.get(f"code_{key}")) for key in code_identity()}
    require_same_code(store.path, begun_by)


def require_same_code(path: Path, begun_by: Mapping[str, str]) -> None:
    """Refuse to go on with a store that other code began.

    Raises
    ------
    RemanentError
        Saying what differs.
    """
    changes = [
        f"{key} was {begun_by.get(key)}, is {value}"
        for key, value in code_identity().items()
        if begun_by.get(key) != value
    ]
    if changes:
        raise RemanentError(
            f"The store {path} was begun by other code, which may give other numbers: "
            f"{'; '.join(changes)}. Go on where it was begun, or pass another place."
        )
