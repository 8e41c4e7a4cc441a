"""Rates at the times at which a load jumps."""

from __future__ import annotations

import pytest

import remanent as rm


@pytest.mark.parametrize("time", [1.5, 4.0])
def test_the_load_after_a_jump_is_taken(time: float) -> None:
    """At a jump the rates are those right after it, asked for alone or with later ones."""
    system = rm.Actuator()
    rates = rm.rates(system, rm.Steps([0.0, 1.5, 4.0], [0.1, -0.2, 0.3]))
    load = {1.5: -0.2, 4.0: 0.3}[time]
    expected = rm.rates(system, rm.Constant(load))(0.0, [1.1, 0.2])
    alone = rates(time, [1.1, 0.2])
    together = rates([time, 9.0], [[1.1, 0.2], [1.1, 0.2]])
    assert alone.tolist() == together[0].tolist() == expected.tolist()


def test_samples_have_rates_up_to_the_last() -> None:
    """The last sample is within the table."""
    rates = rm.rates(rm.Actuator(), rm.Sampled([0.0, 1.0, 2.0], [0.1, 0.2, 0.15]))
    expected = rm.rates(rm.Actuator(), rm.Constant(0.15))(0.0, [1.1, 0.2])
    assert rates(2.0, [1.1, 0.2]) == pytest.approx(expected, rel=1e-14)
