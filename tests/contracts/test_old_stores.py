"""Stores: those that older versions wrote are read as they were on the day they were written."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.results.stores import SCHEMA_VERSION
from remanent.studies.sweep.verify import Integrity, verify_store

#: A file of stores for each version of the schema.
STORES = Path(__file__).parents[1] / "stores"


@pytest.fixture(scope="module", params=range(1, SCHEMA_VERSION + 1))
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The stores of one version, taken out of their file."""
    folder = tmp_path_factory.mktemp("stores")
    with zipfile.ZipFile(STORES / f"version_{request.param}.zip") as file:
        file.extractall(folder)
    return folder


def _values(table: dict[str, Any]) -> Any:
    """The numbers or words of a variable as they were written down."""
    dtype = np.dtype(table["dtype"])
    if dtype.kind == "c":
        real, imag = (np.array(part, dtype=np.float64) for part in table["values"])
        return real + 1j * imag
    return np.array(table["values"], dtype=dtype)


@pytest.mark.parametrize("name", ["orbits", "chart"])
def test_an_old_store_reads_as_it_did(folder: Path, name: str) -> None:
    """Every variable, bit for bit; what was not computed has no status."""
    expected = json.loads((folder / f"{name}.json").read_text())
    ds = rm.load(folder / f"{name}.zarr")
    assert set(map(str, ds.variables)) == set(expected)
    for key, table in expected.items():
        variable = ds.variables[key]
        assert (list(variable.dims), variable.dtype.str) == (table["dims"], table["dtype"])
        np.testing.assert_array_equal(variable.values, _values(table), err_msg=key)


def test_an_old_store_is_verified(folder: Path) -> None:
    """By its checksums; one of the two was never finished."""
    assert verify_store(folder / "chart.zarr").integrity is Integrity.WHOLE
    found = verify_store(folder / "orbits.zarr")
    assert found.integrity is Integrity.INCOMPLETE
    assert (len(found.missing), found.chunk_count) == (2, 3)
    rm.plot.overview(rm.load(folder / "orbits.zarr"))
