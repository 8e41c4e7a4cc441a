"""Physical sizes: energies of the body go with its modulus, density and remanence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.models.physical_sizes import PhysicalSizes

RATIO = {"shear_modulus": 1.2, "density": 0.9, "remanence": 1.3}
#: Units of the body of other sizes over those of the actuator as it was built.
TIME = (RATIO["density"] / RATIO["shear_modulus"]) ** 0.5
STRESS = RATIO["shear_modulus"]
LOAD = RATIO["shear_modulus"] / RATIO["remanence"]
OWN_FIELD = RATIO["remanence"] ** 2 / RATIO["shear_modulus"]
COUPLING = RATIO["shear_modulus"] / RATIO["density"]


@pytest.mark.parametrize(
    ("built", "own"),
    [
        ({"prestress": 0.3}, {"prestress": 0.3 / STRESS}),
        ({"prestress": (0.3, 0.1)}, {"prestress": (0.3 / STRESS, 0.1 / STRESS)}),
        (
            {"dissipation": (rm.Zener(0.5, 1.0), rm.Rayleigh(0.2))},
            {"dissipation": (rm.Zener(0.5 / STRESS, 1.0 / TIME), rm.Rayleigh(0.2 / STRESS / TIME))},
        ),
        pytest.param(
            {"magnet": rm.Magnet(demagnetisation=0.2), "edges": (1.0, 1.3)},
            {"magnet": rm.Magnet(demagnetisation=0.2 * OWN_FIELD), "edges": (1.0, 1.3)},
            marks=pytest.mark.slow,
        ),
        (
            {"heat": rm.Heat(2e-3, exchange=0.2), "magnet": rm.Magnet(-1e-3)},
            {"heat": rm.Heat(2e-3 * COUPLING, exchange=0.2 * TIME), "magnet": rm.Magnet(-1e-3)},
        ),
        ({"material": rm.Gent(20.0)}, {"material": rm.Gent(20.0)}),
    ],
    ids=["one", "two", "viscous", "own field", "warm", "Gent"],
)
def test_a_body_of_other_sizes_moves_as_in_its_own_units(
    built: dict[str, Any], own: dict[str, Any]
) -> None:
    """Law: Reversal and scaling.  Over shear modulus, density and remanence in the built units, or
    with dimensionless numbers in the body's own: the same motion and energies."""
    drive = rm.SineSquared(0.4, 1.25)
    own_drive = rm.SineSquared(0.4 / LOAD**0.5, 1.25 * TIME)
    times = np.linspace(0.0, 6.0, 25)
    over = {name: [ratio] for name, ratio in RATIO.items()}
    one = rm.simulate(rm.Actuator(**built), drive, times=times, over=over).isel(
        dict.fromkeys(over, 0)
    )
    other = rm.simulate(rm.Actuator(**own), own_drive, times=times / TIME)
    np.testing.assert_allclose(one.thickness_stretch, other.thickness_stretch, atol=1e-8)
    np.testing.assert_allclose(
        one.thickness_stretch_rate * TIME, other.thickness_stretch_rate, atol=1e-7
    )
    if "heat" not in built:
        np.testing.assert_allclose(one.energy / STRESS, other.energy, atol=1e-8)


def test_sizes_that_are_not_given_are_those_of_the_body_as_it_was_built() -> None:
    """The sizes with nothing given change no rate: each of them is one."""
    body = rm.Actuator(temperature=320.0, prestress=0.2)
    plain, sized = (
        rm.rates(body.replace(physical_sizes=sizes), rm.Constant(0.3))(0.0, [1.2, 0.4])
        for sizes in (None, PhysicalSizes())
    )
    np.testing.assert_allclose(sized, plain, rtol=1e-13)


@pytest.mark.slow
def test_every_verb_takes_them() -> None:
    """One value of 1 is no change; of an actuator with the sizes as fields of its own too."""
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(0.2)), rm.SineSquared(0.4, 1.25)
    plain = rm.periodic_orbits(body, drive)
    varied = rm.periodic_orbits(body, drive, over={"density": [1.0, 1.1]})
    np.testing.assert_allclose(varied.initial[0], plain.initial, atol=1e-8)
    heavy = rm.periodic_orbits(body.with_parameter("density", 1.1), drive)
    np.testing.assert_allclose(varied.initial[1], heavy.initial, atol=1e-8)
    found = rm.read_system(varied.isel(density=1))
    assert found.parameter_values()["density"] == 1.1
    curve = rm.continue_orbit(body.with_parameter("density", 1.0), drive, "density", (1.0, 1.2))
    assert float(curve.density.max()) == pytest.approx(1.2)
    with pytest.raises(rm.InputError, match="greater than 0"):
        body.with_parameter("density", 0.0)
