"""Reversal and scaling: results at another temperature are the same motions, exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm

HOT = 350.0
ROOT = np.sqrt(HOT / 293.0)
DAMPED = rm.Actuator(prestress=0.3, dissipation=(rm.Rayleigh(0.1),))
HOT_DAMPED = rm.Actuator(
    temperature=HOT, prestress=0.3 * ROOT**2, dissipation=(rm.Rayleigh(0.1 * ROOT),)
)
DRIVE, HOT_DRIVE = rm.SineSquared(0.4, 1.25), rm.SineSquared(0.4 * ROOT, 1.25 * ROOT)


def compared(scaled: xr.Dataset, direct: xr.Dataset, tolerance: float) -> None:
    """Every number of both, and what they say made them."""
    assert set(scaled.variables) == set(direct.variables)
    for name in direct.variables:
        ours, theirs = scaled[name].values, direct[name].values
        if ours.dtype.kind in "fc" and "error" not in str(name):
            np.testing.assert_allclose(ours, theirs, rtol=tolerance, atol=tolerance, err_msg=name)
        elif ours.dtype.kind not in "fc":
            np.testing.assert_array_equal(ours, theirs)
    assert _rounded(scaled.attrs["system_text"]) == _rounded(direct.attrs["system_text"])
    assert _rounded(scaled.attrs["drive_text"]) == _rounded(direct.attrs["drive_text"])


def _rounded(text: str) -> list[str]:
    """A repr with its numbers to 12 digits."""
    parts = text.translate(str.maketrans("=(),'", "     ")).split()
    return [f"{float(one):.12g}" if one[0].isdigit() else one for one in parts]


def test_motion() -> None:
    """Within the two reported errors."""
    times = np.linspace(0.0, 50.0, 101)
    scaled = rm.rescale(rm.simulate(DAMPED, DRIVE, times=times), temperature=HOT)
    compared(scaled, rm.simulate(HOT_DAMPED, HOT_DRIVE, times=times / ROOT), 1e-8)


@pytest.mark.parametrize(
    ("cool", "hot"),
    [
        (
            {"magnet": rm.Magnet(demagnetisation=0.2)},
            {"magnet": rm.Magnet(demagnetisation=0.2 * ROOT**2)},
        ),
        (
            {"dissipation": (rm.Zener(0.5, 1.0), rm.KelvinVoigt(0.1))},
            {"dissipation": (rm.Zener(0.5, ROOT), rm.KelvinVoigt(0.1 * ROOT))},
        ),
        ({"prestress": (0.0, 0.3)}, {"prestress": (0.0, 0.3 * ROOT**2)}),
        *(
            ({"material": solid}, {"material": solid})
            for solid in (
                rm.Gent(20.0),
                rm.MooneyRivlin(0.7, 0.3),
                rm.ArrudaBoyce(3.0),
                rm.Ogden([1.0, 0.1], [1.3, 5.0]),
                rm.StrainEnergy("(I1 - 3)/2 + a*(I1 - 3)**2", {"a": 0.05}),
            )
        ),
    ],
)
def test_every_part_of_an_actuator(cool: dict[str, Any], hot: dict[str, Any]) -> None:
    """A rescaled history is the history at the other temperature, for every part that scales."""
    times = np.linspace(0.0, 10.0, 21)
    scaled = rm.rescale(rm.simulate(rm.Actuator(**cool), DRIVE, times=times), temperature=HOT)
    body = rm.Actuator(temperature=HOT, **hot)
    compared(scaled, rm.simulate(body, HOT_DRIVE, times=times / ROOT), 1e-8)


def test_loads_energies_and_their_balance() -> None:
    """Energies scale with temperature as the loads do."""
    times = np.linspace(0.0, 10.0, 21)
    scaled = rm.rescale(rm.energy_balance(DAMPED, rm.Constant(0.3), times=times), temperature=HOT)
    load = rm.Constant(0.3 * ROOT**2)
    compared(scaled, rm.energy_balance(HOT_DAMPED, load, times=times / ROOT), 1e-8)


@pytest.mark.parametrize("prestress", [0.3, (0.3, 0.1)], ids=["one", "two"])
def test_equilibria(prestress: Any) -> None:
    """With natural frequencies, the stiffness of a difference of stretches, and folds."""
    cool = rm.Actuator(prestress=prestress)
    hot = rm.Actuator(temperature=HOT, prestress=tuple(np.multiply(prestress, ROOT**2)) if
                      isinstance(prestress, tuple) else prestress * ROOT**2)  # fmt: skip
    load = np.array([-0.5, 0.5])
    scaled = rm.rescale(rm.equilibria(cool, over={"m": load}), temperature=HOT)
    compared(scaled, rm.equilibria(hot, over={"m": load * ROOT**2}), 1e-10)


def test_a_response_and_its_window() -> None:
    """Frequencies, durations and widths scale with the root of temperature, attributes included."""
    omega = np.linspace(1.0, 1.4, 9)
    scaled = rm.rescale(
        rm.frequency_response(DAMPED, DRIVE, omega, duration=40.0, resonance_width=1e-4),
        temperature=HOT,
    )
    direct = rm.frequency_response(
        HOT_DAMPED, HOT_DRIVE, omega * ROOT, duration=40.0 / ROOT, resonance_width=1e-4 * ROOT
    )
    assert scaled.attrs["duration"] == pytest.approx(40.0 / ROOT)
    compared(scaled, direct, 1e-8)


def test_orbits() -> None:
    """Rates among the states scale, stretches and multipliers stay."""
    scaled = rm.rescale(rm.periodic_orbits(DAMPED, DRIVE), temperature=HOT)
    direct = rm.periodic_orbits(HOT_DAMPED, HOT_DRIVE)
    compared(scaled.drop_vars("residual"), direct.drop_vars("residual"), 1e-7)


def test_the_fold_of_the_paper_from_the_reference_temperature() -> None:
    """A branch at the reference temperature, rescaled, has the fold of the reproduced article."""
    drive = rm.SineSquared(0.4 / ROOT, 1.25 / ROOT)
    branch = rm.continue_orbit(
        rm.Actuator(), drive, "omega", (1.2 / ROOT, 1.3 / ROOT), initial=(1.433, 0.0)
    )
    hot = rm.rescale(branch, temperature=HOT)
    assert float(hot.special_omega[0]) == pytest.approx(1.26679529184453, abs=1e-10)
    np.testing.assert_allclose(hot.attrs["parameter_range"], (1.2, 1.3))


def test_there_and_back_again() -> None:
    """Round trips change nothing but the last digits, and the bound on the error, upwards."""
    start = rm.simulate(DAMPED, DRIVE, periods=3)
    back = rm.rescale(rm.rescale(start, temperature=HOT), temperature=293.0)
    for name in start.variables:
        if name != "error":
            np.testing.assert_allclose(back[name].values, start[name].values, rtol=1e-14)
    assert (back.error.values >= start.error.values).all()


@pytest.mark.parametrize(
    ("actuator", "reason"),
    [
        (rm.Actuator(material=rm.NeoHookean(entropic_fraction=0.5)), "entropic_fraction = 0.5"),
        (rm.Actuator(magnet=rm.Magnet(temperature_coefficient=-1e-3)), "temperature_coefficient"),
        (rm.Actuator(dissipation=rm.Zener(0.5, 1.0, rm.WLF(8.0, 200.0))), "shift = WLF"),
        (rm.Actuator(heat=rm.Heat()), "heat = Heat"),
    ],
)
def test_what_does_not_scale_is_refused(actuator: rm.Actuator, reason: str) -> None:
    """Where a constant depends on temperature by itself, the message names it."""
    result = rm.simulate(actuator, DRIVE, periods=1)
    with pytest.raises(rm.InputError, match=reason):
        rm.rescale(result, temperature=HOT)


def test_several_temperatures_are_refused() -> None:
    """Results at several temperatures are refused together, and rescaled one by one."""
    result = rm.simulate(rm.Actuator(), DRIVE, periods=1, over={"temperature": [250.0, 350.0]})
    with pytest.raises(rm.InputError, match="one temperature"):
        rm.rescale(result, temperature=HOT)
    assert float(rm.rescale(result.isel(temperature=0), temperature=HOT).temperature) == HOT


@dataclass(frozen=True)
class Kicked(rm.Constant):
    """A drive with a field that no table describes."""

    kick: float = 1.0


def test_a_drive_of_unknown_fields_is_refused() -> None:
    """A drive whose scaling is not known is refused."""
    result = rm.simulate(rm.Actuator(), rm.Constant(0.2), duration=2.0)
    with pytest.raises(rm.InputError, match="how this one scales"):
        rm.rescale(result, temperature=HOT, drive=Kicked(0.2))


@pytest.mark.parametrize(
    "drive",
    [
        rm.Steps([0.0, 1.0], [0.1, 0.2]),
        rm.Ramp([0.0, 1.0, 2.0], [0.0, 0.2, 0.1]),
        rm.Sampled([0.0, 1.0, 2.0, 3.0], [0.0, 0.1, 0.2, 0.1]),
        rm.Sines([0.1, 0.2], [1.0, 3.0], 1.2, mean=0.1),
        rm.Chirp(0.2, 1.0, 2.0, 3.0),
        rm.Sine(0.2, 1.2, mean=0.1, phase=0.4),
    ],
    ids=lambda drive: type(drive).__name__,
)
def test_every_drive(drive: Any) -> None:
    """The rescaled history is that under the rescaled drive, which the result has."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    times = np.linspace(0.0, 2.9, 9)
    scaled = rm.rescale(rm.simulate(body, drive, times=times), temperature=HOT)
    again = rm.simulate(rm.read_system(scaled), rm.read_drive(scaled), times=times / ROOT)
    compared(scaled, again, 1e-8)
    np.testing.assert_allclose(scaled["load"], ROOT**2 * drive(times), rtol=1e-12, atol=1e-12)


def test_a_dropped_value_of_a_varied_field_is_refused() -> None:
    """A result that no longer says its temperature or prestress is not scaled from another."""
    over = {"temperature": [250.0, 350.0], "prestress": [0.0, 0.4]}
    result = rm.simulate(rm.Actuator(), DRIVE, periods=1, over=over)
    chosen = result.isel(temperature=0, prestress=1)
    assert float(rm.rescale(chosen, temperature=HOT).temperature) == HOT
    for name in over:
        with pytest.raises(rm.InputError, match=f"without {name}"):
            rm.rescale(chosen.drop_vars(name), temperature=HOT)
