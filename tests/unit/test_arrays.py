"""What the one gate for arrays lets in, and with what remedy it refuses.

Law: Bad input.
"""

from __future__ import annotations

import datetime
import inspect
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import remanent as rm
from remanent._arrays import as_float_array
from remanent._errors import InputError

#: The package without its types, for calls that they forbid.
LOOSE: Any = rm
LOOSE_MS: Any = pint.Quantity(1.0, "ms")
DRIVE = rm.SineSquared(0.4, 1.25)
FILM = rm.Actuator.from_si(
    shear_modulus="100 kPa", density="2000 kg/m3", half_length="5 mm", half_thickness="0.5 mm",
    remanence="143 mT",
)  # fmt: skip
WORDS: dict[str, Any] = {"what": "numbers", "why": "They are needed.", "fix": "Pass numbers."}

#: Data that NumPy would turn into floats, with a word of the remedy.
NO_NUMBERS: dict[str, tuple[Any, str]] = {
    "masked": (np.ma.masked_array([1.0, 9.0], [False, True]), "compressed"),
    "complex in a DataArray": (xr.DataArray(np.array([1j])), "Pass numbers"),
    "complex": (np.array([1.0 + 0j]), "Pass numbers"),
    "truth values": ([True, False], "Pass numbers"),
    "objects": (np.array([1.0, None], dtype=object), "Pass numbers"),
    "text": (["1", "2"], "Pass numbers"),
    "ragged": ([1.0, [2.0]], "Pass numbers"),
    "lengths of time": (np.array([1, 2], "m8[ms]"), r"actuator\.time"),
    "a length of time": (datetime.timedelta(1), r"actuator\.time"),
    "times in a DataArray": (xr.DataArray(np.array([1, 2], "m8[ns]")), r"actuator\.time"),
    "dates": (np.array(["2020"], "M8[D]"), r"actuator\.time"),
    "times of pandas": (pd.Series(pd.to_timedelta([1], "ms")), r"actuator\.time"),
    "a quantity": (pint.Quantity(np.array([1.0, 2.0]), "ms"), "Convert it first"),
    "quantities": ([pint.Quantity(1.0, "ms")], "Convert it first"),
    "a structure": (np.zeros(2, [("x", float)]), "Pass numbers"),
}


@pytest.mark.parametrize("case", NO_NUMBERS)
def test_what_is_no_number_is_refused(case: str) -> None:
    """With a remedy for its kind, and in few letters."""
    value, remedy = NO_NUMBERS[case]
    with pytest.raises(InputError, match=remedy) as caught:
        as_float_array("x", value, **WORDS)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    "kind", [list, tuple, np.array, np.ma.masked_array, pd.Series, xr.DataArray, np.float32]
)
@given(values=st.lists(st.floats(width=32), min_size=1, max_size=5))
def test_numbers_in_any_container_are_the_same(
    kind: Callable[[list[float]], Any], values: list[float]
) -> None:
    """Bit for bit, as a new array of the caller's own."""
    container = kind(values)
    floats = as_float_array("x", container, **WORDS)
    np.testing.assert_array_equal(floats, np.array(values))
    floats[:] = 0.0
    np.testing.assert_array_equal(np.asarray(container), np.array(values))


def test_gaps_are_nan_where_they_mean_something() -> None:
    """A masked entry, and a missing one of pandas."""
    masked = np.ma.masked_array([1, 9, 3], [False, True, False])
    missing = pd.Series([1, None, 3], dtype="Int64")
    for value in (masked, missing):
        found = as_float_array("x", value, gaps=True, **WORDS)
        np.testing.assert_array_equal(found, [1.0, np.nan, 3.0])


def test_a_number_of_a_result_is_a_number() -> None:
    """A DataArray without dimensions, as `response.resonance` is."""
    ds = rm.frequency_response(rm.Actuator(), DRIVE, np.linspace(1.0, 1.4, 5), duration=20.0)
    assert DRIVE.replace(omega=ds.resonance).omega == float(ds.resonance)
    assert LOOSE.Constant(xr.DataArray(0.25)) == rm.Constant(0.25)
    assert LOOSE.equilibria(rm.Actuator(), xr.DataArray(0.1)).sizes


def test_units_are_converted_where_the_actuator_has_sizes() -> None:
    """Times, frequencies and loads in `times`, `omega` and `over`, and refused elsewhere."""
    instants = pint.Quantity(np.array([0.0, 1.0, 2.0]), "ms")
    ticks = np.array([0, 1, 2], "m8[ms]")
    for times in (instants, ticks):
        ds = rm.simulate(FILM, DRIVE, times=times)
        np.testing.assert_allclose(ds.time, FILM.time(instants), rtol=1e-14)
    hertz = pint.Quantity(np.array([50.0, 60.0]), "Hz")
    ds = rm.frequency_response(FILM, DRIVE, hertz, duration=5.0)
    np.testing.assert_allclose(ds.omega, FILM.frequency(hertz), rtol=1e-14)
    over = {"omega": hertz, "b": pint.Quantity(np.array([100.0, 140.0]), "mT")}
    ds = rm.simulate(FILM, DRIVE, duration=1.0, over=over)
    np.testing.assert_allclose(ds.omega, FILM.frequency(hertz), rtol=1e-14)
    np.testing.assert_allclose(ds.b**2, FILM.load(["100 mT", "140 mT"]), rtol=1e-14)
    for length in (5.0 * LOOSE_MS, np.timedelta64(5, "ms"), datetime.timedelta(milliseconds=5)):
        ds = LOOSE.simulate(FILM, DRIVE, duration=length)
        assert ds.attrs["duration"] == float(ds.time[-1]) == FILM.time("5 ms")
    for call in (
        lambda: rm.simulate(rm.Actuator(), DRIVE, times=instants),
        lambda: rm.simulate(rm.Actuator(), DRIVE, times=ticks),
        lambda: LOOSE.simulate(rm.Actuator(), DRIVE, duration=LOOSE_MS),
        lambda: LOOSE.simulate(FILM, DRIVE, duration=hertz[0]),
        lambda: LOOSE.Sampled(instants, [0.0, 0.1, 0.2]),
        lambda: rm.simulate(FILM, DRIVE, times=hertz),
    ):
        with pytest.raises(InputError, match=r"from_si|dimension of s"):
            call()


def test_lengths_of_runs_and_ranges_have_units_wherever_they_are_asked_for() -> None:
    """Each number with a unit gives the result of the number that stands for it."""
    body, step = FILM.replace(dissipation=rm.Rayleigh(0.1)), rm.Constant(0.1)
    band = pint.Quantity(np.array([270.0, 290.0]), "Hz")

    def times(length: Any, start: Any) -> list[xr.Dataset]:
        return [
            rm.crossings(body, DRIVE, "stretch", 1.0, duration=length),
            rm.energy_balance(body, DRIVE, duration=length),
            rm.frequency_response(body, DRIVE, [1.0, 1.2], duration=length, discard=start),
            rm.step_response(body, step, duration=length),
        ]

    plain = times(FILM.time("9 ms"), FILM.time("2 ms"))
    for ds, same in zip(times(9.0 * LOOSE_MS, 2.0 * LOOSE_MS), plain, strict=True):
        xr.testing.assert_identical(ds, same)
    ds = rm.continue_orbit(body, DRIVE, "omega", band)
    xr.testing.assert_identical(ds, rm.continue_orbit(body, DRIVE, "omega", FILM.frequency(band)))


@pytest.mark.parametrize("container", [list, tuple, np.array, xr.DataArray])
def test_texts_with_units_are_read_as_quantities_are(container: Callable[..., Any]) -> None:
    """Values, times and lengths as one writes them; text without a unit is refused."""
    texts = container(["50 Hz", "60 Hz"])
    if isinstance(texts, xr.DataArray):
        texts = texts.rename(dim_0="case")
    ds = rm.simulate(FILM, DRIVE, duration=1.0, over={"omega": texts})
    np.testing.assert_array_equal(ds.omega, FILM.frequency(["50 Hz", "60 Hz"]))
    ds = LOOSE.simulate(FILM, DRIVE, times=container(["0 ms", "2 ms"]))
    np.testing.assert_array_equal(ds.time, FILM.time(["0 ms", "2 ms"]))
    assert LOOSE.simulate(FILM, DRIVE, duration="5 ms").attrs["duration"] == FILM.time("5 ms")
    refused: list[list[Any]] = [["1.0", "2.0"], ["50 Hz", 2.0], ["50 Hz", "fast"], ["3 mT"]]
    for words in refused:
        with pytest.raises(InputError, match="Hz"):
            rm.simulate(FILM, DRIVE, duration=1.0, over={"omega": words})
    with pytest.raises(InputError, match="number without a unit"):
        rm.simulate(FILM, DRIVE, duration=1.0, over={"c": ["1 mm"]})


def test_sizes_with_units_are_over_those_the_actuator_was_built_with() -> None:
    """Shear modulus, density and remanence in `over`: the labels are ratios."""
    over = {
        "shear_modulus": pint.Quantity(np.array([90.0, 110.0]), "kPa"),
        "density": pint.Quantity(np.array([1.9, 2.1]), "g/cm^3"),
        "remanence": pint.Quantity(np.array([130.0, 143.0]), "mT"),
    }
    ds = rm.simulate(FILM, DRIVE, duration=1.0, over=over)
    np.testing.assert_allclose(ds.shear_modulus, [0.9, 1.1], rtol=1e-14)
    np.testing.assert_allclose(ds.density, [0.95, 1.05], rtol=1e-14)
    np.testing.assert_allclose(ds.remanence, [130.0 / 143.0, 1.0], rtol=1e-14)
    with pytest.raises(InputError, match="from_si"):
        rm.simulate(rm.Actuator(), DRIVE, duration=1.0, over=over)


CALLS: dict[str, tuple[Callable[[], Any], str]] = {
    "unknown": (lambda: LOOSE.simulate(FILM, DRIVE, duratoin=1.0), "Did you mean `duration`"),
    "missing": (lambda: LOOSE.simulate(FILM), "`drive` must be given to simulate"),
    "by position": (lambda: LOOSE.simulate(FILM, DRIVE, 3.0), "at most 2 arguments"),
    "twice": (lambda: LOOSE.Gent(1.0, jm=2.0), "`jm` must be given once"),
    "constructor": (LOOSE.Gent, "`jm` must be given to Gent"),
    "field": (lambda: LOOSE.Actuator(temprature=300), "Did you mean `temperature`"),
    "sizes": (LOOSE.Actuator.from_si, "`shear_modulus` must be given"),
    "class": (lambda: LOOSE.Actuator(material=rm.Gent), r"Write Gent\(\.\.\.\)"),
    "number": (lambda: LOOSE.Actuator(dissipation=0.05), r"Pass for example rm\.Rayleigh\(0\.05\)"),
    "empty text": (lambda: LOOSE.Actuator(dissipation=""), "`dissipation` must be a Dissipation"),
    "scales": (lambda: LOOSE.Actuator(scales=5), "`scales` must be"),
    "swapped": (lambda: LOOSE.simulate(DRIVE, FILM, duration=1.0), "Pass the system first"),
    "many values": (lambda: FILM.frequency(np.linspace(50.0, 1000.0, 400)), r"\.\.\."),
    "no netCDF": (lambda: LOOSE.load(__file__.replace(".py", ".nc")), "There is none of that name"),
}  # fmt: skip


@pytest.mark.parametrize("case", CALLS)
def test_calls_that_do_not_fit_are_told_in_words(case: str) -> None:
    """The argument, the rule and the remedy, in place of a TypeError."""
    call, message = CALLS[case]
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert len(str(caught.value)) < 600


def test_explained_functions_stay_what_they_are() -> None:
    """They keep their signatures, and can be pickled by their public names."""
    assert pickle.loads(pickle.dumps(rm.simulate)) is rm.simulate  # noqa: S301, made here
    assert list(inspect.signature(rm.simulate).parameters)[:2] == ["system", "drive"]
    assert list(inspect.signature(rm.Gent).parameters) == ["jm", "entropic_fraction"]
    with pytest.raises(TypeError, match="user's own"):
        rm.simulate(FILM, DRIVE, duration=1.0, progress=fail)


def fail(_: float) -> None:
    raise TypeError("the user's own")


def test_a_file_of_another_kind_is_no_netcdf(tmp_path: Any) -> None:
    """The message says so, not that HDF5 cannot synchronise."""
    path = tmp_path / "table.nc"
    path.write_text("time,stretch\n0,1\n")
    with pytest.raises(InputError, match="signature of HDF5"):
        rm.load(path)
