"""Energies keep their digits in the form that they are written in for derivatives."""

from __future__ import annotations

import pytest
import sympy as sp

import remanent as rm
from remanent.derivation.block import build_motion
from remanent.derivation.symbols import THICKNESS_STRETCH, parameter_symbol


@pytest.mark.parametrize("prestress", [0.0, (0.0, 0.0)], ids=["one", "two"])
def test_ogdens_energy_in_principal_stretches_is_the_sum_of_their_powers(
    prestress: float | tuple[float, float],
) -> None:
    """W sum(a m) = 2 sum(m (l1^a + l2^a + l3^a - 3)/a), without l1 l2 l3 = 1 being used again."""
    material = rm.Ogden.example()
    motion = build_motion(rm.Actuator(material=material, prestress=prestress), None)
    names = ("exponents", "moduli")
    exponents, moduli = (
        [parameter_symbol(f"material.{name}.{k}") for k in range(len(material.exponents))]
        for name in names
    )
    pair = motion.coordinates * (2 // len(motion.coordinates))
    total = sum(
        2 * m * (sum(stretch**a for stretch in (*pair, THICKNESS_STRETCH)) - 3) / a
        for a, m in zip(exponents, moduli, strict=True)
    )
    over = sum(a * m for a, m in zip(exponents, moduli, strict=True))
    found = motion.in_principal_stretches(motion.energies.strain.energy)
    assert sp.expand(found * over - total) == 0
