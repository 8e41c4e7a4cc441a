"""Laws of colours: every pair that has to be told apart is apart, for every common reader."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from remanent.plots import colours, style
from tests.unit.plots import vision

#: Shades of chaos and of tori, from end to end.
SHARES = np.linspace(0.0, 1.0, 33)
#: Least distance of two colours that are told apart, CIE 1976.
LEAST_DISTANCE = 20.0
#: Least difference in lightness of neighbours in an order.
LEAST_STEP = 10.0


@pytest.mark.parametrize("eye", [vision.NORMAL, vision.DEUTERANOPIA], ids=["usual", "deuteranopia"])
def test_regimes_are_told_apart(eye: np.ndarray) -> None:
    """Any two periods, chaos, tori and escapes differ by 20 and more."""
    chaos, tori = colours.CHAOS_COLOUR_MAP(SHARES), colours.TORUS_COLOUR_MAP(SHARES)
    groups = [[tone] for tone in colours.PERIOD_COLOURS] + [list(chaos)]
    for one, other in itertools.combinations(groups, 2):
        assert vision.distances(one, other, eye).min() >= LEAST_DISTANCE, (one[0], other[0])
    for tone in colours.PERIOD_COLOURS:
        assert vision.distances([tone], tori, eye).min() >= LEAST_DISTANCE, tone
    assert vision.distances(list(chaos), tori, eye).min() >= LEAST_DISTANCE


def test_one_period_and_the_next_differ_in_a_grey_print() -> None:
    """Lightness changes by 10 and more from each period to the next, and to the double."""
    found = vision.lightness(colours.PERIOD_COLOURS)
    assert np.abs(np.diff(found)).min() >= LEAST_STEP
    assert abs(found[1] - found[3]) >= LEAST_STEP


def test_shades_only_rise_in_lightness() -> None:
    """Exponents, rotation numbers, temperatures and numbers keep their order in grey."""
    temperatures = colours.temperature_colour_map()
    for map_ in (colours.CHAOS_COLOUR_MAP, colours.TORUS_COLOUR_MAP, temperatures,
                 colours.number_colour_map()):  # fmt: skip
        assert (np.diff(vision.lightness(map_(SHARES))) > 0.0).all(), map_.name


def test_lines_can_be_read_on_white() -> None:
    """Every colour of a line has a contrast of 3 with paper."""
    lines = [*colours.OKABE_ITO_COLOURS.values(), *colours.number_colours(range(5)),
             *colours.temperature_colours([240.0, 300.0, 410.0])]  # fmt: skip
    assert vision.contrast_with_white(lines).min() >= 2.99


@pytest.mark.parametrize("eye", [vision.NORMAL, vision.DEUTERANOPIA], ids=["usual", "deuteranopia"])
def test_published_temperatures_and_a_few_numbers_are_told_apart(eye: np.ndarray) -> None:
    """250, 350 and 400 K, and up to five numbers, differ by 10 in lightness or 20 in colour."""
    for tones in (
        colours.temperature_colours([250.0, 350.0, 400.0]),
        colours.number_colours([1.0, 5.0, 7.0]),
        colours.number_colours([1.0, 2.0, 3.0, 4.0, 5.0]),
    ):
        for one, other in itertools.pairwise(tones):
            apart = vision.distances([one], [other], eye)[0, 0]
            step = abs(np.diff(vision.lightness([one, other]))[0])
            assert apart >= LEAST_DISTANCE or step >= LEAST_STEP


def test_words_differ_in_colour_and_in_line_style() -> None:
    """Any two words have another colour by 20, or another line style."""
    tones = colours.category_colours(7)
    for j, k in itertools.combinations(range(7), 2):
        apart = vision.distances([tones[j]], [tones[k]], vision.DEUTERANOPIA)[0, 0]
        styles = len(style.LINE_STYLES)
        assert apart >= LEAST_DISTANCE or j % styles != k % styles


def test_a_temperature_keeps_its_colour_beside_one_that_is_missing() -> None:
    """A temperature that is NaN changes no other colour."""
    whole = colours.temperature_colours([250.0, 350.0, 400.0])
    assert colours.temperature_colours([250.0, np.nan, 400.0])[::2] == whole[::2]


@pytest.mark.parametrize("values", [(0.1, 1.0, 100.0), (1.0, 1.001, 50.0), tuple(range(5, 0, -1))])
def test_numbers_are_ordered_by_lightness(values: tuple[float, ...]) -> None:
    """However they are spaced and sorted, the smallest is the darkest."""
    found = vision.lightness(colours.number_colours(values))
    np.testing.assert_array_equal(np.argsort(found), np.argsort(values))
