"""Boxes of states: what they default to, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._checks import require_heat_exchange, require_state_box

DRIVE = rm.SineSquared(0.4, 1.25)
WARM = rm.Actuator(heat=rm.Heat(1e-3, exchange=0.1), dissipation=rm.Rayleigh(0.1))


def test_a_box_without_a_temperature_is_refused_by_name() -> None:
    """NaN around the body leaves no default; a given pair needs none."""
    ens = lay_out_ensemble(WARM, DRIVE, {"temperature": [np.nan, 300.0]})
    assert require_state_box("state_box", None, ens)[-1].tolist() == [295.0, 305.0]
    with pytest.raises(rm.InputError, match=r"^`box` must name state variables, stretch"):
        require_state_box("box", {"strech": (0.3, 4.0)}, ens)
    with pytest.raises(rm.InputError, match=r"^`box` must give stretch a lower"):
        require_state_box("box", {"stretch": (4.0, 0.3)}, ens)
    ds = rm.periodic_orbits(WARM, DRIVE, over={"temperature": [np.nan, 300.0]})
    assert ds.status.values.tolist() == [rm.Status.INVALID, rm.Status.OK]
    assert ds.orbits.values.tolist()[0] == 0
    assert ds.orbits.values.tolist()[1] > 0


def test_only_what_warms_without_exchange_is_refused() -> None:
    """One adiabatic member of an ensemble is enough; without a temperature nothing warms."""
    for actuator in (WARM, rm.Actuator(dissipation=rm.Rayleigh(0.1))):
        require_heat_exchange(lay_out_ensemble(actuator, DRIVE))
    for exchange in ([0.0], [0.0, 0.1]):
        ens = lay_out_ensemble(WARM, DRIVE, {"heat.exchange": exchange})
        with pytest.raises(rm.InputError, match="exchange heat where its temperature is a state"):
            require_heat_exchange(ens)


def test_without_a_box_orbits_are_looked_for_where_the_pages_say() -> None:
    """Promise: stretches from 0.3 to 4, rates from -8 to 8, temperatures up to 5 K from outside."""
    ens = lay_out_ensemble(WARM.replace(prestress=(0.1, 0.1), temperature=310.0), DRIVE)
    bounds = require_state_box("state_box", None, ens).tolist()
    assert dict(zip(ens.vector_field.state_names, bounds, strict=True)) == {
        "stretch_1": [0.3, 4.0],
        "stretch_1_rate": [-8.0, 8.0],
        "stretch_2": [0.3, 4.0],
        "stretch_2_rate": [-8.0, 8.0],
        "body_temperature": [305.0, 315.0],
    }
