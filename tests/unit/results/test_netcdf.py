"""Laws of files."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from remanent._errors import InputError
from remanent.results import build, netcdf, provenance


@pytest.fixture
def everything() -> xr.Dataset:
    """Build a Dataset with every type that results have."""
    return build.dataset(
        {
            "amplitude": (("temperature", "omega"), np.array([[1.0, np.nan, 1e-300]] * 2)),
            "status": (("temperature",), np.array([1, 3])),
            "multipliers": (("orbit", "multiplier"), np.array([[1 + 2j, 1 - 2j], [-1, 0.5j]])),
            "stability": (("orbit",), np.array(["elliptic", "saddle"])),
            "period": (("orbit",), np.array([1, 2**40])),
            "dissipation.0.eta": ((), np.array(0.1)),
        },
        {
            "temperature": (("temperature",), np.array([250.0, 350.0])),
            "omega": (("omega",), np.array([1.0, 1.1, 1.2])),
            "law": (("temperature",), np.array(["b^2 sin^2", ""])),
            "phase": ((), np.array(0.25)),
        },
        provenance.attributes("Actuator()", None, 1e-9, note="θ = 1, λ₃", empty="", many=3),
    ).assign(closed=("temperature", np.array([True, False]), {"units": "1"}))


def test_round_trip(everything: xr.Dataset, tmp_path: Path) -> None:
    """What is read equals what was written: values, types, names, attributes, coordinates."""
    found = netcdf.read(netcdf.write(everything, tmp_path / "all.nc"))
    xr.testing.assert_identical(found, everything)
    for name, variable in everything.variables.items():
        assert found[name].dtype == variable.dtype, name


def test_equal_datasets_give_equal_bytes(everything: xr.Dataset, tmp_path: Path) -> None:
    """A file depends on its Dataset alone, and a Dataset read back writes the same file."""
    first = netcdf.write(everything, tmp_path / "first.nc")
    second = netcdf.write(everything.copy(deep=True), tmp_path / "second.nc")
    third = netcdf.write(netcdf.read(first), tmp_path / "third.nc")
    assert first.read_bytes() == second.read_bytes() == third.read_bytes()


def test_files_keep_to_the_classic_model(everything: xr.Dataset, tmp_path: Path) -> None:
    """No groups, and no variable is complex, boolean, string or 64-bit integer."""
    allowed = {"i1", "i2", "i4", "f4", "f8"}
    with h5py.File(netcdf.write(everything, tmp_path / "all.nc")) as file:
        assert {"multipliers_real", "multipliers_imag"} <= set(file)
        for name, item in file.items():
            assert isinstance(item, h5py.Dataset), name
            assert item.dtype.str[1:] in allowed, name


def test_attributes_are_plain_text(everything: xr.Dataset, tmp_path: Path) -> None:
    """Text attributes have a fixed length, which every version of MATLAB reads."""
    with h5py.File(netcdf.write(everything, tmp_path / "all.nc")) as file:
        for owner, key in ((file, "system_text"), (file["amplitude"], "units")):
            text = h5py.check_string_dtype(owner.attrs.get_id(key).dtype)
            assert text is not None
            assert text.length is not None


def test_strings_become_cf_flags(everything: xr.Dataset, tmp_path: Path) -> None:
    """A program that knows nothing of this package can read the words."""
    raw = xr.load_dataset(netcdf.write(everything, tmp_path / "all.nc"), engine="h5netcdf")
    stability, law = raw["stability"], raw["law"]
    assert stability.dtype == np.int8
    words = stability.attrs["flag_meanings"].split()
    assert [words[k] for k in stability.values] == ["elliptic", "saddle"]
    assert law.attrs["flag_meanings"] == "none b^2_sin^2"


def test_a_failed_write_leaves_the_old_file(everything: xr.Dataset, tmp_path: Path) -> None:
    """A file is replaced whole or not at all."""
    path = netcdf.write(everything, tmp_path / "all.nc")
    before = path.read_bytes()
    objects = xr.Dataset({"x": ("y", np.array([object(), None]))})
    with pytest.raises(InputError, match="numbers, booleans or strings"):
        netcdf.write(objects, path)
    assert path.read_bytes() == before


def test_integers_that_fit_nowhere_are_refused(tmp_path: Path) -> None:
    """An integer is stored exactly or not at all."""
    with pytest.raises(InputError, match=r"2\^53"):
        netcdf.write(xr.Dataset({"n": ("k", np.array([2**60 + 1]))}), tmp_path / "x.nc")
