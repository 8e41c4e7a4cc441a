"""Computing what is damaged or missing in a store, and nothing else."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from remanent.results.stores import BOOKKEEPING, LENGTH_ENDING
from remanent.studies.sweep.layout import create_store
from remanent.studies.sweep.locks import sole_writer
from remanent.studies.sweep.run import ReportProgress, run_here
from remanent.studies.sweep.sample import sample_here
from remanent.studies.sweep.store import (
    Store,
    open_store,
    require_same_code,
    seal_description,
)
from remanent.studies.sweep.study import Study
from remanent.studies.sweep.verify import Findings, code_of_store, study_of_store, verify_store


def repair_store(path: Path, report: ReportProgress | None = None) -> Findings:
    """Compute again what is damaged, and what is missing.

    Returns
    -------
    Findings
        What was wrong before.

    Raises
    ------
    InputError, RemanentError
        There is no store, its numbers were made by other code, or another process writes it.
    """
    path = path.resolve()
    study = study_of_store(path)
    require_same_code(path, code_of_store(path))
    (path / BOOKKEEPING).mkdir(exist_ok=True)
    with sole_writer(path / BOOKKEEPING, (1, 1)):
        found = verify_store(path)
        if found.description:
            _rewrite_description(path, study)
            again = verify_store(path)
            found = Findings(found.description, again.damaged, again.missing, again.chunk_count)
        store = open_store(path)
        for chunk in found.damaged:
            store.forget(chunk)
        run_here(store, report=report)
    return found


def _rewrite_description(path: Path, study: Study) -> None:
    """Write description and shared values anew, from the study; the numbers of chunks stay."""
    fresh_path = path / BOOKKEEPING / "fresh.zarr"
    shutil.rmtree(fresh_path, ignore_errors=True)
    fresh = create_store(fresh_path, study, sample_here(study, fresh_path))
    for name in fresh.names:
        source, target = fresh_path / name, path / name
        _restore_length(fresh, name, target, path)
        target.mkdir(exist_ok=True)
        (source / "zarr.json").replace(target / "zarr.json")
        if (source / "c").exists():
            shutil.rmtree(target / "c", ignore_errors=True)
            (source / "c").replace(target / "c")
    for file in ("zarr.json", f"{BOOKKEEPING}/zarr.json", f"{BOOKKEEPING}/study.json"):
        (fresh_path / file).replace(path / file)
    shutil.rmtree(fresh_path)
    seal_description(path)


def _restore_length(fresh: Store, name: str, target: Path, path: Path) -> None:
    """Make an array as long along lists as it was, or as the lists of points are."""
    array = fresh.array(name)
    dims = array.metadata.dimension_names
    old = _old_shape(target, len(dims))
    shape = tuple(
        have if dim in fresh.grid_dims else max(have, was, _longest_list(path, fresh, dim))
        for dim, have, was in zip(dims, array.shape, old, strict=True)
    )
    if shape == array.shape:
        return
    array.resize(shape)
    if dims == (name,):
        array[...] = np.arange(shape[0])


def _old_shape(folder: Path, rank: int) -> tuple[int, ...]:
    """The shape in a description that can still be read; zeros where it cannot."""
    try:
        description = json.loads((folder / "zarr.json").read_text(encoding="utf-8"))
        shape = tuple(map(int, description["shape"]))
    except (OSError, ValueError, KeyError, TypeError):
        return (0,) * rank
    return shape if len(shape) == rank else (0,) * rank


def _longest_list(path: Path, fresh: Store, dim: str) -> int:
    """The longest list along a dimension, by the lengths that can still be read."""
    name = f"{dim}{LENGTH_ENDING}"
    if name not in fresh.names:
        return 0
    try:
        values: Any = open_store(path).array(name)[...]
    except Exception:  # whatever a damaged store raises
        return 0
    return int(np.max(values, initial=0))
