"""What a stranger's measurements mean, and what is refused of them, in words that help.

Law: Bad input.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pint
import pytest
import scipy.io
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import remanent as rm
from remanent.results.mat_reader import read_mat

PHYSICAL = rm.Actuator.from_si(
    shear_modulus="1 MPa", density="2000 kg/m^3", half_length="5 mm", half_thickness="0.5 mm",
    remanence="1 T", force="3 N",
)  # fmt: skip
#: Milliseconds and millimetres as a person writes them, with a column that means nothing here.
TABLE = "Time [ms],Thickness [mm],Coil current [A]\n0,1.0,2\n1.5,1.01,3\n2,1.02,4\n"


def tau(text: str) -> float:
    return float(PHYSICAL.time(text))


TAU = [0.0, tau("1.5 ms"), tau("2 ms")]
#: Over the undeformed thickness, twice 0.5 mm.
STRETCH = [1.0, 1.01, 1.02]


def written(tmp_path: Path, content: str | bytes) -> Path:
    path = tmp_path / "table.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


SPELLINGS: Mapping[str, str | bytes] = {
    "commas": TABLE,
    "semicolons": TABLE.replace(",", ";"),
    "tabs": TABLE.replace(",", "\t"),
    "decimal commas": TABLE.replace(",", ";").replace(".", ","),
    "decimal commas and tabs": TABLE.replace(",", "\t").replace(".", ","),
    "UTF-8 with a mark": "\ufeff" + TABLE,
    "UTF-16": TABLE.encode("utf-16"),
    "UTF-16 without a mark": TABLE.encode("utf-16-le"),
    "Latin-1": TABLE.replace("Coil current [A]", "Gerät [Ω]".replace("Ω", "µA")).encode("latin-1"),
    "an index": "\n".join(
        f"{k - 1 if k else ''},{line}" for k, line in enumerate(TABLE.splitlines())
    ),
    "strokes": TABLE.replace("Time [ms]", "Time / ms").replace("Thickness [mm]", "thickness/mm"),
    "round brackets": TABLE.replace("[", "(").replace("]", ")"),
    "a row of units": TABLE.replace(
        "Time [ms],Thickness [mm],Coil current [A]", "Time,Thickness,Current\nms,mm,A"
    ),
    "lines before the headings": "Instrument: 7\nDate,2020-01-01\n\n" + TABLE,
    "comments": "# made by hand\n" + TABLE.replace("\n1.5", "\n# a pause\n1.5"),
    "missing values": TABLE + "3,,5\n4,n/a,5\n",
    "blanks at the ends": TABLE.replace(",", " , "),
    "Windows": TABLE.replace("\n", "\r\n"),
    "other order": "\n".join([TABLE.splitlines()[0], *reversed(TABLE.splitlines()[1:])]),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:`data`")
@pytest.mark.parametrize("spelling", SPELLINGS)
def test_one_table_in_many_spellings(spelling: str, tmp_path: Path) -> None:
    """Delimiter, decimal sign, encoding, index, units: the same times and stretches."""
    ds = rm.read_measurements(written(tmp_path, SPELLINGS[spelling]), PHYSICAL)
    assert list(ds.data_vars) == ["thickness_stretch"]
    np.testing.assert_allclose(ds.time, TAU, rtol=1e-13)
    np.testing.assert_allclose(ds.thickness_stretch, STRETCH, rtol=1e-13)


def test_columns_that_mean_nothing_are_named(tmp_path: Path) -> None:
    """They are left aside with one warning, and the result says which."""
    with pytest.warns(rm.InputWarning, match=r"left aside: 'Coil current \[A\]'") as caught:
        ds = rm.read_measurements(written(tmp_path, TABLE), PHYSICAL)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert ds.attrs["left_aside"] == "Coil current [A]"


ROWS = st.lists(
    st.tuples(st.floats(0.0, 1e6), st.floats(-1e6, 1e6)), min_size=1, max_size=6,
    unique_by=lambda row: row[0],
)  # fmt: skip


@given(rows=ROWS, delimiter=st.sampled_from(",;\t| "), decimal=st.sampled_from(".,"))
def test_any_numbers_in_any_form(
    tmp_path_factory: pytest.TempPathFactory,
    rows: list[tuple[float, float]],
    delimiter: str,
    decimal: str,
) -> None:
    """What a program writes with all digits comes back bit for bit, sorted by time."""
    delimiter = ";" if delimiter == decimal else delimiter
    lines = [delimiter.join(repr(x).replace(".", decimal) for x in row) for row in rows]
    text = "\n".join([delimiter.join(("time", "stretch")), *lines])
    ds = rm.read_measurements(written(tmp_path_factory.mktemp("tables"), text))
    found = list(zip(ds.time.values.tolist(), ds.stretch.values.tolist(), strict=True))
    assert found == sorted(rows)


HALF = np.timedelta64(500, "us")
MEANINGS: Mapping[str, tuple[Any, dict[str, list[float]]]] = {
    "lengths of time": (
        {"time": np.arange(3) * HALF, "stretch": [1.0, 1.1, 1.2]},
        {"time": [0.0, tau("0.5 ms"), tau("1 ms")]},
    ),
    "dates": (
        {"time": np.datetime64("2020-01-01T00:00", "us") + np.arange(2) * HALF,
         "stretch": [1.0, 1.1]},
        {"time": [0.0, tau("0.5 ms")]},
    ),
    "an index of times": (
        pd.DataFrame({"stretch": [1.0, 1.1]}, index=pd.to_timedelta([0, 1], "ms")),
        {"time": [0.0, tau("1 ms")]},
    ),
    "quantities": (
        {"time": pint.Quantity([0.0, 1.0], "ms"), "thickness": pint.Quantity([1.0, 1.1], "mm")},
        {"time": [0.0, tau("1 ms")], "thickness_stretch": [1.0, 1.1]},
    ),
    "edges": (
        {"time": [0.0, 1.0], "stretch [cm]": [1.0, 1.1]},
        {"stretch": [1.0, 1.1]},
    ),
    "amplitudes": (
        {"frequency [Hz]": [50.0, 60.0], "amplitude [um]": [10.0, 20.0],
         "frequency_error [Hz]": [1.0, 2.0]},
        {"omega": [float(PHYSICAL.frequency("50 Hz")), float(PHYSICAL.frequency("60 Hz"))],
         "amplitude": [0.01, 0.02],
         "omega_error": [float(PHYSICAL.frequency("1 Hz")), float(PHYSICAL.frequency("2 Hz"))]},
    ),
    "degrees": (
        {"time": [0.0, 1.0], "body_temperature [degC]": [20.0, 21.0],
         "body_temperature_error [degC]": [0.5, 0.5]},
        {"body_temperature": [293.15, 294.15], "body_temperature_error": [0.5, 0.5]},
    ),
    "masks": (
        {
            "time": [0.0, 1.0, 2.0],
            "stretch": np.ma.masked_array([1.0, 9.0, 1.1], [False, True, False]),
        },
        {"time": [0.0, 2.0], "stretch": [1.0, 1.1]},
    ),
    "missing integers": (
        {"time": pd.Series([0, 1, None], dtype="Int64"), "stretch": [1.0, 1.1, 1.2]},
        {"time": [0.0, 1.0], "stretch": [1.0, 1.1]},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MEANINGS)
def test_containers_and_units_are_understood(case: str) -> None:
    """Times, lengths, temperatures and their deviations become what they stand for."""
    data, expected = MEANINGS[case]
    ds = rm.read_measurements(data, PHYSICAL)
    for name, values in expected.items():
        np.testing.assert_allclose(ds[name], values, rtol=1e-12, err_msg=name)


def test_measurements_turn_back_to_si() -> None:
    """There and back: milliseconds, millimetres and their errors are those of the table."""
    table = {
        "time [ms]": [0.0, 1.0, 2.0], "thickness [mm]": [1.0, 1.02, 1.01],
        "thickness_error [mm]": [0.01, 0.02, 0.01],
    }  # fmt: skip
    ds = rm.read_measurements(table, PHYSICAL)
    assert rm.read_system(ds) == PHYSICAL
    back = rm.to_si(ds, lengths=True)
    names = ("time", "thickness_stretch", "thickness_stretch_error")
    for name, column in zip(names, table.values(), strict=True):
        np.testing.assert_allclose(back[name], column, rtol=1e-14)
    assert [back[name].units for name in names] == ["ms", "mm", "mm"]


def test_a_masked_outlier_does_not_move_a_fit() -> None:
    """The fit is that of the values that are not masked."""
    true = rm.Actuator(dissipation=rm.Rayleigh(0.3))
    run = rm.simulate(true, rm.Constant(0.3), times=np.linspace(0.0, 10.0, 60))
    values = np.ma.masked_array(run.thickness_stretch.values.copy(), np.arange(60) == 20)
    values.data[20] = 9.0
    data = {"time": run.time.values, "thickness_stretch": values}
    guess = rm.Actuator(dissipation=rm.Rayleigh(0.2))
    found = rm.fit(guess, rm.Constant(0.3), data, ["dissipation.0.eta"])
    assert float(found.estimate[0]) == pytest.approx(0.3, abs=1e-6)


REFUSED: Mapping[str, tuple[Any, str]] = {
    "no sizes": ("time [ms],stretch\n0,1\n1,1\n", "from_si"),
    "wrong unit": ({"time": [0.0], "body_temperature [kg]": [1.0]}, "dimension of K"),
    "misspelt": ("time,strech\n0,1\n1,1\n", "mean 'stretch' by 'strech'"),
    "no time": ({"stretch": [1.0, 1.0]}, "`time` or `omega`"),
    "two abscissae": ({"time": [0.0], "omega": [1.0], "amplitude": [1.0]}, "one of the two"),
    "two times": ("time [ms],time [s],stretch\n0,0,1\n1,2,3\n", "one column for time"),
    "a line without end": ("a" * 10**6 + ",time\n1,2\n", "field larger"),
    "same heading": ("time,time,stretch\n0,0,1\n1,2,3\n", "Two of its columns are called"),
    "infinite": ("time,stretch\n0,1\n1,inf\n", "inf in row 2"),
    "too large": ("time,stretch\n0,1\n1,1e400\n", "inf in row 2"),
    "before 0": ("time,stretch\n-1,1\n1,1\n", "start at time 0"),
    "no frequency": ("omega,amplitude\n0,1\n1,1\n", "frequencies above 0"),
    "repeated": ("time,stretch\n0,1\n0,2\n1,1\n", "more than one at time = 0"),
    "no number": ("time,stretch\n0,1\n1,OVER\n", "'OVER' in row 2"),
    "commas twice": ("time,stretch\n0,0,1,0\n0,1,1,1\n", "need semicolons"),
    "no headings": ("0,1\n1,1\n", "no row of headings"),
    "prose": ("hello\n", "no rows of at least two numbers"),
    "nothing": ("", "no rows of at least two numbers"),
    "a spreadsheet": (b"PK\x03\x04 and more", "save the sheet as CSV"),
    "bytes": (b"\x01\x02\x03\x00\x04" * 9, "no text"),
    "missing file": (Path("missing.csv"), "Check the path"),
    "long path": (Path("x" * 5000), "Check the path"),
    "unequal lengths": ({"time": [0.0, 1.0], "stretch": [1.0, 1.1, 1.2]}, "as long"),
    "a matrix": ({"time": np.ones((2, 2)), "stretch": np.ones((2, 2))}, "one column"),
    "complex": ({"time": [0.0, 1.0], "stretch": [1.0, 1j]}, "real numbers"),
    "truth values": ({"time": [0.0, 1.0], "stretch": [True, False]}, "real numbers"),
    "objects": ({"time": [0.0, 1.0], "stretch": [1.0, object()]}, "real numbers"),
    "text": ({"time": [0.0, 1.0], "stretch": ["1", "2"]}, "real numbers"),
    "SI": (rm.to_si(rm.simulate(PHYSICAL, rm.Constant(0.1), duration=1.0)), "dimensionless"),
    "complex Dataset": (xr.Dataset({"stretch": ("time", [1j])}, {"time": [0.0]}), "real numbers"),
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:`data`")
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_measurement_is_refused(case: str, tmp_path: Path) -> None:
    """The message says what is wrong, and where."""
    data, message = REFUSED[case]
    source = written(tmp_path, data) if isinstance(data, str | bytes) else data
    with pytest.raises(rm.InputError, match=message) as caught:
        rm.read_measurements(source)
    assert len(str(caught.value)) < 1500


def test_names_and_units_given_by_hand() -> None:
    """A heading is called as it stands, with or without its unit; others do not come in."""
    table = {"t1 [ms]": [0.0, 1.0], "time": [5.0, 6.0], "gap": [1.0, 1.1]}
    names = {"t1": "time", "gap": "thickness"}
    with pytest.warns(rm.InputWarning, match="left aside: 'time'"):
        ds = rm.read_measurements(table, PHYSICAL, names=names, units={"gap": "mm"})
    np.testing.assert_allclose(ds.time, [0.0, tau("1 ms")])
    np.testing.assert_allclose(ds.thickness_stretch, [1.0, 1.1])
    with pytest.raises(rm.InputError, match="can be measured"):
        rm.read_measurements(table, names={"gap": "nothing"})
    with pytest.raises(rm.InputError, match="be of columns"):
        rm.read_measurements(table, units={"nothing": "mm"})


@pytest.mark.filterwarnings("ignore:`data`")
@pytest.mark.parametrize(
    "heading", ["[" * 50_000, "(" * 50_000, "1 T**9**9**9", "a" * 10**5, "x [" + "m*" * 9999 + "m]"]
)
def test_long_headings_do_not_hang(heading: str, tmp_path: Path) -> None:
    """They are left aside; limits on length and depth keep every pattern short."""
    ds = rm.read_measurements(written(tmp_path, f"{heading},time,stretch\n1,0,1\n2,1,1\n"))
    assert list(ds.data_vars) == ["stretch"]


VARIABLES = {
    "time": np.arange(3.0)[:, None], "stretch": np.ones((3, 1)), "rate": 1000.0,
    "about": {"who": "me"}, "words": np.array(["ab", "", "çé"], dtype=object), "note": "text",
    "is_good": np.array([True, False]), "z": np.array([1 + 2j, 3.0]),
    "i": np.array([[1, 2]], dtype=np.int16),
}  # fmt: skip


@pytest.mark.parametrize("compressed", [False, True])
def test_mat_files_are_read_as_scipy_reads_them(compressed: bool, tmp_path: Path) -> None:
    """Numbers, truth values and text; structures are named, and other variables left aside."""
    path = tmp_path / "x.mat"
    scipy.io.savemat(path, VARIABLES, do_compression=compressed)
    found, reference = read_mat(path), scipy.io.loadmat(path)
    assert found.other_names == ("about",)
    for name in ("time", "stretch", "rate", "is_good", "z", "i"):
        np.testing.assert_array_equal(found.arrays[name], reference[name])
    assert found.arrays["words"].ravel().tolist() == ["ab", "", "çé"]
    assert found.arrays["note"].tolist() == ["text"]
    with pytest.warns(rm.InputWarning, match="'rate'.*'about'"):
        ds = rm.read_measurements(path)
    assert ds.stretch.values.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.filterwarnings("ignore:`data`")
def test_damaged_mat_files_are_refused(tmp_path: Path) -> None:
    """Whatever bytes are changed or missing: an InputError or an answer, and no crash."""
    path, damaged = tmp_path / "x.mat", tmp_path / "y.mat"
    draw = random.Random(1)
    for compressed in (False, True):
        scipy.io.savemat(path, VARIABLES, do_compression=compressed)
        sound = path.read_bytes()
        for _ in range(150):
            content = bytearray(sound)
            for _ in range(draw.choice([1, 3, 30])):
                content[draw.randrange(len(content))] = draw.randrange(256)
            length = draw.choice([len(content), draw.randrange(len(content))])
            damaged.write_bytes(content[:length])
            with suppress(rm.InputError):
                assert isinstance(rm.read_measurements(damaged), xr.Dataset)
