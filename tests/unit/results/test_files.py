"""Laws of `save` and `load`, in every format."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import scipy.io
import xarray as xr
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

import remanent as rm
from remanent.results import atomic, build, provenance

ENDINGS = (".nc", ".csv", ".mat")
every = pytest.mark.parametrize("ending", ENDINGS)


@pytest.fixture
def everything() -> xr.Dataset:
    """One table with every type that results have, and values that are easily lost."""
    system = rm.Actuator(material=rm.Gent(1 / 3), dissipation=rm.Rayleigh(0.1))
    awkward = np.array([[1 / 3, np.nan, -0.0], [np.inf, 5e-324, 1e300]])
    pairs = np.array([complex(-0.0, np.inf), complex(np.nan, -0.0), 1 / 3 - 2j])
    return build.dataset(
        {
            "amplitude": (("temperature", "omega"), awkward),
            "multipliers": (("omega",), pairs),
            "status": (("temperature",), np.array([1, 3])),
            "regime": (("temperature",), np.array(["chaotic, weakly", ""])),
            "law": (("omega",), np.array(["# θ", 'b "sin"²\n', "False"])),
            "period": (("omega",), np.array([1, -1, 2**40])),
            "resonance": ((), np.array(1.25)),
        },
        {
            "temperature": (("temperature",), np.array([250.0, 350.0])),
            "omega": (("omega",), np.array([1.0, 1.1, 1.2])),
            "dissipation.0.eta": ((), np.array(0.1)),
        },
        provenance.attributes(system, None, 1e-9, note="θ = 1, λ₃", ranges=(1.0, 1 / 3), many=3),
    ).assign(
        closed=("temperature", np.array([True, False]), {"units": "1"}),
        small=("omega", np.array([1, 2, 3], dtype=np.float32), {"units": "1"}),
    )


def same(first: xr.Dataset, second: xr.Dataset) -> None:
    """Both are identical, types and signs of zeros included; that of a NaN has no meaning."""
    xr.testing.assert_identical(first, second)
    for name, variable in second.variables.items():
        ours, theirs = first[name].values, variable.values
        assert ours.dtype.kind == theirs.dtype.kind
        if ours.dtype.kind != "U":
            assert ours.dtype == theirs.dtype
        if ours.dtype.kind in "fc":
            parts = [(ours.real, theirs.real), (ours.imag, theirs.imag)]
            for one, other in parts:
                number = ~np.isnan(other)
                np.testing.assert_array_equal(np.signbit(one[number]), np.signbit(other[number]))


@every
def test_round_trip(ending: str, everything: xr.Dataset, tmp_path: Path) -> None:
    """load(save(x)) = x: values bit for bit, types, names, dimensions, attributes."""
    path = rm.save(everything, tmp_path / f"all{ending}")
    loaded = rm.load(path)
    same(loaded, everything)
    assert provenance.read_system(loaded) == rm.Actuator(
        material=rm.Gent(1 / 3), dissipation=rm.Rayleigh(0.1)
    )
    assert list(tmp_path.iterdir()) == [path]


@every
def test_equal_datasets_make_equal_files(
    ending: str, everything: xr.Dataset, tmp_path: Path
) -> None:
    """A file depends on its Dataset alone; one that was read back makes it again."""
    first = rm.save(everything, tmp_path / f"first{ending}")
    second = rm.save(everything.copy(deep=True), str(tmp_path / f"second{ending}"))
    third = rm.save(rm.load(first), tmp_path / f"third{ending}")
    assert first.read_bytes() == second.read_bytes() == third.read_bytes()


@given(
    values=nps.arrays(np.float64, nps.array_shapes(min_dims=0, max_dims=3, min_side=0)),
    text=st.lists(
        st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=5),
        max_size=4,
    ),
    truth=st.booleans(),
)
@example(values=np.array(0.0), text=[" "], truth=False)
@example(values=np.array(-np.nan), text=[], truth=False)
def test_any_values_come_back(
    tmp_path_factory: pytest.TempPathFactory, values: Any, text: list[str], truth: bool
) -> None:
    """Any shape, empty ones included, any float and any text, in netCDF and MAT files."""
    dims = tuple(f"d{k}" for k in range(values.ndim))
    words = np.array(text, dtype=np.str_)
    dataset = xr.Dataset(
        {
            "x": (dims, values),
            "z": (dims, np.exp(1j * np.where(np.isfinite(values), values, 0.0))),
            "word": ("w", words),
            "truth": ((), np.array(truth)),
        },
        attrs={"text": "".join(text)},
    )
    folder = tmp_path_factory.mktemp("any")
    for ending in (".nc", ".mat"):
        same(rm.load(rm.save(dataset, folder / f"x{ending}")), dataset)
    table = dataset[["x", "z", "truth"]] if values.size else dataset[["x", "z"]]
    same(rm.load(rm.save(table, folder / "x.csv")), table)


@every
def test_results_of_verbs(ending: str, tmp_path: Path) -> None:
    """A motion and a grid of motions, as they are."""
    drive = rm.SineSquared(0.4, 1.25)
    for result in (
        rm.simulate(rm.Actuator(), drive, times=[0.0, 1.0, 2.0]),
        rm.frequency_response(
            rm.Actuator(), drive, [1.0, 1.1, 1.2], duration=5.0, over={"temperature": [250, 350]}
        ),
    ):
        same(rm.load(rm.save(result, tmp_path / f"result{ending}")), result)


@pytest.mark.parametrize("ending", [".nc", ".mat"])
def test_branches(ending: str, tmp_path: Path) -> None:
    """Complex multipliers, text and special points; a branch that is loaded can be left."""
    damped, drive = rm.Actuator(dissipation=rm.Rayleigh(0.01)), rm.SineSquared(0.8, 2.4)
    branch = rm.continue_orbit(damped, drive, "omega", (2.35, 2.45))
    loaded = rm.load(rm.save(branch, tmp_path / f"branch{ending}"))
    same(loaded, branch)
    assert provenance.read_system(loaded) == damped
    assert provenance.read_drive(loaded) == drive


def test_several_tables_are_refused_as_csv(tmp_path: Path) -> None:
    """No rows are made up: variables must be of one table."""
    dataset = xr.Dataset({"x": ("a", [1.0]), "y": ("b", [1.0, 2.0])})
    with pytest.raises(rm.InputError, match="one table"):
        rm.save(dataset, tmp_path / "x.csv")
    rm.save(dataset[["y"]], tmp_path / "y.csv")


def test_a_table_without_rows_is_refused_where_it_would_lose_something(tmp_path: Path) -> None:
    """A scalar has no place in a table without rows."""
    dataset = xr.Dataset({"x": ("a", np.empty(0)), "y": ((), 1.0)})
    with pytest.raises(rm.InputError, match="no place for `y`"):
        rm.save(dataset, tmp_path / "x.csv")


def test_pandas_reads_the_table(everything: xr.Dataset, tmp_path: Path) -> None:
    """Headings are names, rows are points, the comments are comments."""
    dataset = everything.drop_vars(["law", "regime"])
    frame = pd.read_csv(rm.save(dataset, tmp_path / "x.csv"), comment="#")
    assert {"omega", "temperature", "amplitude", "multipliers_real"} <= set(frame.columns)
    assert len(frame) == 6
    row = frame[(frame.temperature == 350.0) & (frame.omega == 1.2)]
    assert row.amplitude.item() == 1e300
    assert row.closed.dtype == bool
    assert not row.closed.item()


def test_measurements_are_read_from_what_was_saved(tmp_path: Path) -> None:
    """A saved motion can be fitted to, as any other record."""
    motion = rm.simulate(rm.Actuator(), rm.Constant(0.1), times=[0.0, 1.0, 2.0])
    saved = rm.save(motion[["thickness_stretch"]], tmp_path / "x.csv")
    read = rm.read_measurements(saved)
    np.testing.assert_array_equal(read.thickness_stretch, motion.thickness_stretch)


def test_matlab_names_and_types(everything: xr.Dataset, tmp_path: Path) -> None:
    """Names are those of MATLAB, vectors are columns, text is a cell array."""
    contents = scipy.io.loadmat(rm.save(everything, tmp_path / "x.mat"))
    names = [name for name in contents if not name.startswith("__")]
    assert all(name.isidentifier() and name[0].isalpha() for name in names)
    assert contents["dissipation_0_eta"].item() == 0.1
    assert contents["omega"].shape == (3, 1)
    assert np.iscomplexobj(contents["multipliers"])
    assert contents["regime"].dtype == object
    assert contents["metadata"].dtype.kind == "U"


@pytest.mark.parametrize("name", ["x.hdf", "x", "x.nc.gz"])
def test_unknown_endings_are_refused(name: str, tmp_path: Path) -> None:
    """The message has the endings that there are."""
    for call in (lambda: rm.save(xr.Dataset(), tmp_path / name), lambda: rm.load(tmp_path / name)):
        with pytest.raises(rm.InputError, match=r"\.nc, \.csv, \.mat"):
            call()


@every
def test_missing_places_are_refused(ending: str, tmp_path: Path) -> None:
    """A folder is not made, and a file that is not there is no empty result."""
    with pytest.raises(rm.InputError, match="a folder that exists"):
        rm.save(xr.Dataset(), tmp_path / "none" / f"x{ending}")
    with pytest.raises(rm.InputError, match="none of that name"):
        rm.load(tmp_path / f"x{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    with pytest.raises(rm.InputError, match="can be written"):
        rm.save(xr.Dataset(), tmp_path / f"folder{ending}")


@every
@pytest.mark.parametrize("content", [b"", b"omega,amplitude\n1,2\n", bytes(range(256))])
def test_damaged_files_are_refused(ending: str, content: bytes, tmp_path: Path) -> None:
    """What was not written by `save` raises in words."""
    path = tmp_path / f"x{ending}"
    path.write_bytes(content)
    with pytest.raises(rm.InputError, match="path"):
        rm.load(path)


@every
def test_a_failed_write_leaves_the_old_file(
    ending: str, everything: xr.Dataset, tmp_path: Path
) -> None:
    """A file is replaced whole or not at all, and nothing is left beside it."""
    path = rm.save(everything, tmp_path / f"x{ending}")
    before = path.read_bytes()
    for broken in (
        xr.Dataset({"x": ("y", np.array([object(), None]))}),
        xr.Dataset({"x": ("y", [1.0])}, attrs={"made_by": print}),
    ):
        with pytest.raises(rm.InputError):
            rm.save(broken, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupted_write_leaves_the_old_file(tmp_path: Path) -> None:
    """The new file takes the place of the old one once it is complete."""
    path = tmp_path / "x.csv"
    path.write_text("old")

    def interrupted() -> None:
        with atomic.atomic_replacement(path) as part:
            part.write_text("half of the n")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_array_is_refused(tmp_path: Path) -> None:
    """The remedy says how to make a Dataset of it."""
    with pytest.raises(rm.InputError, match="to_dataset"):
        rm.save(xr.DataArray([1.0]), tmp_path / "x.nc")  # type: ignore[arg-type]


def test_a_table_needs_no_netcdf(tmp_path: Path) -> None:
    """Formats are imported when they are used: `save` of a table loads no h5py, no SciPy."""
    code = (
        "import sys, xarray as xr, remanent as rm\n"
        f"rm.save(xr.Dataset({{'x': ('y', [1.0])}}), {str(tmp_path / 'x.csv')!r})\n"
        "assert not {'h5py', 'h5netcdf', 'scipy.io'} & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
