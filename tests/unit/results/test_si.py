"""Laws of SI units."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import xarray as xr

from remanent._errors import InputError
from remanent.results import build, si

#: The realistic set of the physics page: mu = 100 kPa, rho = 2000 kg/m3, L = 5 mm, B_r = 143 mT.
MU, RHO, LENGTH, REMANENCE, MU_0 = 1e5, 2000.0, 5e-3, 0.143, 4e-7 * math.pi
TIME = LENGTH * math.sqrt(RHO / MU)
SCALES = {
    "time_s": TIME,
    "frequency_hz": 1 / (2 * math.pi * TIME),
    "load_T": MU * MU_0 / REMANENCE,
    "stress_pa": MU,
}


@pytest.fixture
def result() -> xr.Dataset:
    """Build a Dataset with one variable of every kind."""
    return build.dataset(
        {
            "load": (("time",), np.array([0.16, 0.0])),
            "stretch": (("time",), np.array([1.0, 1.1])),
            "stretch_rate": (("time",), np.array([0.0, 1.0])),
            "energy": (("time",), np.array([0.5, 0.5])),
            "horizon": ((), np.array(100.0)),
            "resonance": ((), np.array(1.25)),
            "resonance_error": ((), np.array(0.01)),
            "error": ((), np.array(1e-10)),
        },
        {
            "time": (("time",), np.array([0.0, 10.0])),
            "omega": ((), np.array(2 * math.pi)),
            "b": ((), np.array(0.4)),
            "prestress": ((), np.array(1.0)),
            "temperature": ((), np.array(350.0)),
            "dissipation.0.eta": ((), np.array(0.1)),
        },
        {"scales": json.dumps(SCALES), "tolerance": 1e-9},
    )


def test_known_conversions(result: xr.Dataset) -> None:
    """Each kind turns by its own scale; b^2, not b, is proportional to the field."""
    found = si.to_si(result)
    expected = {
        "time": (10 * TIME * 1e3, "ms"),
        "omega": (1 / TIME, "Hz"),
        "b": (0.16 * MU * MU_0 / REMANENCE * 1e3, "mT"),
        "load": (0.16 * MU * MU_0 / REMANENCE * 1e3, "mT"),
        "prestress": (100.0, "kPa"),
        "energy": (50.0, "kJ m-3"),
        "stretch_rate": (1 / TIME, "s-1"),
        "resonance_error": (0.01 / (2 * math.pi * TIME), "Hz"),
        "dissipation.0.eta": (0.1 * MU * TIME, "Pa s"),
    }
    for name, (value, units) in expected.items():
        assert float(found[name].max()) == pytest.approx(value, rel=1e-14), name
        assert found[name].attrs["units"] == units, name
    assert float(found["b"]) == pytest.approx(140.6, abs=0.1)


def test_what_has_no_si_value_stays(result: xr.Dataset) -> None:
    """Stretches, temperatures and the error of the dimensionless state stay."""
    found = si.to_si(result)
    for name in ("stretch", "temperature", "error"):
        xr.testing.assert_identical(found[name].variable, result[name].variable)


def test_symbols_follow(result: xr.Dataset) -> None:
    """Where the quantity changes, so do its symbol and its name in words."""
    found = si.to_si(result)
    symbols = {"time": "t", "omega": "f", "resonance": "f_r", "horizon": "t_h", "load": "B"}
    for name, symbol in symbols.items():
        assert found[name].attrs["symbol"] == symbol
    assert found["load"].attrs["long_name"] == "flux density"


def test_the_argument_is_untouched(result: xr.Dataset) -> None:
    """Conversion makes a new Dataset."""
    before = result.copy(deep=True)
    si.to_si(result)
    xr.testing.assert_identical(result, before)


def test_scales_are_needed_once(result: xr.Dataset) -> None:
    """Without scales, or in SI already, conversion is refused with the remedy."""
    with pytest.raises(InputError, match=r"Actuator\.from_si"):
        si.to_si(result.drop_attrs())
    with pytest.raises(InputError, match="in SI already"):
        si.to_si(si.to_si(result))


def test_loads_stay_without_a_remanence(result: xr.Dataset) -> None:
    """Flux density needs the remanence; without it loads keep their unit, all else turns."""
    scales = {name: value for name, value in SCALES.items() if name != "load_T"}
    found = si.to_si(result.assign_attrs(scales=json.dumps(scales)))
    assert found["b"].attrs["units"] == found["load"].attrs["units"] == "1"
    np.testing.assert_array_equal(found["load"].values, result["load"].values)
    assert found["time"].attrs["units"] == "ms"


def test_incomplete_scales_are_refused(result: xr.Dataset) -> None:
    """A missing scale is named."""
    result.attrs["scales"] = json.dumps({"time_s": 1.0})
    with pytest.raises(InputError, match="stress_pa"):
        si.to_si(result)
