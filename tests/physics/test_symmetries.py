"""What cannot change the motion: running it back, and the units it is written in.

Law: Reversal and scaling.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.models.drives.base import Drive

END = 24.0
TIMES = np.linspace(0.0, END, 121)
KNOTS = np.array([0.0, 3.0, 7.5, 11.0, 19.0, END])
LOADS = np.array([0.3, -0.4, 0.9, -0.2, 0.5, 0.1])
SINE = rm.Sine(0.6, 1.3, 0.2, 0.4)
SQUARED = rm.SineSquared(0.8, 1.1, 0.3)
CHIRP = rm.Chirp(0.5, 0.4, 2.0, END, 0.1, 0.2)
#: The angle of the chirp when it ends.
TURNED = 0.2 + 0.5 * (0.4 + 2.0) * END
#: Each load, and the same load with time running back from END.
REVERSED: dict[str, tuple[Drive, Drive]] = {
    "constant": (rm.Constant(0.4), rm.Constant(0.4)),
    "sine": (SINE, rm.Sine(-0.6, 1.3, 0.2, -(1.3 * END + 0.4))),
    "sine squared": (SQUARED, rm.SineSquared(0.8, 1.1, -(1.1 * END + 0.3))),
    "steps": (
        rm.Steps(KNOTS[:-1], LOADS[:-1]),
        rm.Steps((END - KNOTS[::-1])[:-1], LOADS[:-1][::-1]),
    ),
    "ramp": (rm.Ramp(KNOTS, LOADS), rm.Ramp(END - KNOTS[::-1], LOADS[::-1])),
    "sampled": (rm.Sampled(KNOTS, LOADS), rm.Sampled(END - KNOTS[::-1], LOADS[::-1])),
    "chirp": (CHIRP, rm.Chirp(-0.5, 2.0, 0.4, END, 0.1, -TURNED)),
}


@pytest.mark.parametrize("name", REVERSED)
def test_forward_then_back(name: str) -> None:
    """Under the reversed load the undamped motion runs back, to 100 times the tolerance.

    Law: Reversal and scaling.
    """
    forward, backward = REVERSED[name]
    tolerance = 1e-10
    bodies = {
        "c": xr.DataArray([1.0, 0.3, 0.05], dims="case"),
        "prestress": xr.DataArray([0.0, 0.8, 1.5], dims="case"),
        "temperature": xr.DataArray([250.0, 350.0, 400.0], dims="case"),
    }
    there = rm.simulate(rm.Actuator(), forward, times=TIMES, over=bodies, tolerance=tolerance)
    turned = {
        "initial.stretch": xr.DataArray(there.stretch.values[:, -1], dims="case"),
        "initial.stretch_rate": xr.DataArray(-there.stretch_rate.values[:, -1], dims="case"),
    }
    back = rm.simulate(
        rm.Actuator(), backward, times=TIMES, over={**bodies, **turned}, tolerance=tolerance
    )
    assert (there.status == 1).all()
    assert (back.status == 1).all()
    for variable, sign in (("stretch", 1.0), ("stretch_rate", -1.0)):
        gone, come = there[variable].values, sign * back[variable].values[:, ::-1]
        assert np.abs(gone - come).max() <= 100.0 * tolerance


#: Drives of random numbers with the load, and the frequencies, divided by what they are given.
SCALED: dict[str, Callable[[float, float], Drive]] = {
    "constant": lambda load, _: rm.Constant(0.5 / load),
    "sine": lambda load, rate: rm.Sine(0.5 / load, 1.4 / rate, -0.2 / load, 0.7),
    "sine squared": lambda load, rate: rm.SineSquared(0.6 / math.sqrt(load), 1.1 / rate, 0.2),
    "chirp": lambda load, rate: rm.Chirp(
        0.4 / load, 0.3 / rate, 2.0 / rate, 80.0 * rate, 0.1 / load, 0.5
    ),
    "steps": lambda load, rate: rm.Steps(4.0 * KNOTS[:-1] * rate, LOADS[:-1] / load),
    "sampled": lambda load, rate: rm.Sampled(4.5 * KNOTS * rate, LOADS / load),
}


@pytest.mark.parametrize("eta", [0.0, 0.1])
@pytest.mark.parametrize("theta", [0.5, 1.9])
@pytest.mark.parametrize("name", SCALED)
def test_temperature_scales_out_of_every_drive(name: str, theta: float, eta: float) -> None:
    """(theta; m, S, eta, tau) and (1; m/theta, S/theta, eta/sqrt theta, tau sqrt theta).

    Law: Reversal and scaling.
    """
    root = math.sqrt(theta)
    times = np.linspace(0.0, 100.0, 101)
    slenderness, prestress = np.array([1.0, 0.1, 0.02]), np.array([0.1, 0.6, 1.2])
    runs = []
    for warmth, load, rate in ((theta, 1.0, 1.0), (1.0, theta, root)):
        body = rm.Actuator(
            temperature=300.0 * warmth,
            reference_temperature=300.0,
            dissipation=rm.Rayleigh(eta / rate) if eta else (),
        )
        over = {
            "c": xr.DataArray(slenderness, dims="case"),
            "prestress": xr.DataArray(prestress / load, dims="case"),
        }
        runs.append(rm.simulate(body, SCALED[name](load, rate), times=times * rate, over=over))
    warm, cold = runs
    # of a motion that magnifies errors, what both trust
    both = (warm.error + cold.error).values[:, None]
    trusted = times[None] * root <= np.minimum(warm.horizon * root, cold.horizon).values[:, None]
    assert trusted.mean() > 0.8
    stretch = np.abs(warm.stretch.values - cold.stretch.values)
    rates = np.abs(warm.stretch_rate.values / root - cold.stretch_rate.values)
    # a rate of the warm motion is divided by the root, and so is its error
    allowed = both * max(1.0, 1.0 / root)
    assert (np.where(trusted, stretch, 0.0) <= both).all()
    assert (np.where(trusted, rates, 0.0) <= allowed).all()


FILM: dict[str, Any] = {
    "shear_modulus": "80 kPa",
    "density": "1900 kg/m^3",
    "half_length": "4 mm",
    "half_thickness": "0.9 mm",
    "remanence": "120 mT",
    "temperature": "340 K",
    "force": "150 mN",
}


def test_dimensional_and_dimensionless_runs_are_one_motion() -> None:
    """An actuator in SI and the same numbers worked out by hand, over tau <= 100.

    Law: Reversal and scaling.
    """
    film = rm.Actuator.from_si(**FILM)
    unit = 4e-3 * math.sqrt(1900.0 / 80e3)
    omega = 2.0 * math.pi * 300.0 * unit
    load = 0.12 * 0.2 / (80e3 * 1.25663706127e-6)
    stress = 0.15 / (4.0 * 4e-3 * 0.9e-3) / 80e3
    plain = rm.Actuator(c=(0.9 / 4.0) ** 2, temperature=340.0, prestress=stress)
    drives = (
        rm.Sine(float(film.load("200 mT")), float(film.frequency("300 Hz"))),
        rm.Sine(load, omega),
    )
    times = np.linspace(0.0, 100.0, 201)
    si, hand = (
        rm.simulate(body, drive, times=times)
        for body, drive in zip((film, plain), drives, strict=True)
    )
    both = float(si.error + hand.error)
    assert int(si.status) == int(hand.status) == 1
    assert np.abs(si.stretch.values - hand.stretch.values).max() <= both
    assert np.abs(si.stretch_rate.values - hand.stretch_rate.values).max() <= both
    seconds = rm.to_si(si)
    assert seconds.stretch.values == pytest.approx(si.stretch.values, rel=0, abs=0)
    scale = {"s": 1.0, "ms": 1e-3, "us": 1e-6}[seconds.time.attrs["units"]]
    assert seconds.time.values * scale / unit == pytest.approx(times, rel=1e-14)
