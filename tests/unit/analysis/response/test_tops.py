"""The top of a polynomial, and what says how well it is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Chebyshev

from remanent.analysis.response.tops import top_of_polynomials

#: Chebyshev's nodes, where polynomials of another degree are orthogonal to each other.
NODES = np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)


@pytest.mark.parametrize("top", [-0.6, 0.1, 0.7])
def test_the_cut_off_is_what_the_highest_coefficients_move(top: float) -> None:
    """c T_8 beside a polynomial of low degree: that of degree 6 through the values is without it.

    So the cut-off is the whole way from the top without c T_8 to the one with it.
    """
    smooth = 1.0 - (NODES - top) ** 2
    alone = top_of_polynomials(NODES, smooth, 0.0)
    assert alone is not None
    assert abs(alone.place - top) < 1e-14
    assert alone.cut_off < 1e-14
    wave = Chebyshev.basis(8)
    disturbed = top_of_polynomials(NODES, smooth + 1e-3 * wave(NODES), 0.0)
    assert disturbed is not None
    slope = 2.0 * (top - disturbed.place) + 1e-3 * wave.deriv()(disturbed.place)
    assert abs(slope) < 1e-13
    assert disturbed.cut_off == pytest.approx(abs(disturbed.place - top), abs=1e-13)
    assert disturbed.cut_off > 1e-4
    assert disturbed.error >= disturbed.cut_off


@pytest.mark.parametrize("top", [-0.6, 0.1])
def test_noise_moves_the_top_by_what_the_highest_coefficients_show(top: float) -> None:
    """Law: the root mean square of the seen noise is that of how far random errors move the top."""
    rng = np.random.default_rng(7)
    smooth = 1.0 - (NODES - top) ** 2
    tops = [
        top_of_polynomials(NODES, smooth + 1e-6 * rng.standard_normal(NODES.size), 0.0)
        for _ in range(150)
    ]
    found = [one for one in tops if one is not None]
    assert len(found) == len(tops)
    moved = np.sqrt(np.mean([(one.place - top) ** 2 for one in found]))
    seen = np.sqrt(np.mean([one.seen_noise**2 for one in found]))
    assert seen == pytest.approx(moved, rel=0.25)
