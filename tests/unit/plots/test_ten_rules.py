"""The ten rules of figures, for every public function of ``rm.plot``.

1. What is drawn exists.  2. What is missing is named.  3. Colour is an ordered number, or a word
with a second cue.  4. No two entries of a legend are alike.  5. Colours can be told apart.
6. Many members have a colour bar, and a legend takes a quarter of the height at most.  7. All text
lies inside a small figure and can be read.  8. Files have TrueType fonts and fine pixels.  9. The
user's axes stay as they were.  10. Axes say meaning, symbol and unit.
"""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Iterator
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

import remanent as rm
from remanent.plots import colours
from remanent.plots.footer import footer_text
from tests.unit.plots import pictures, vision
from tests.unit.plots.pictures import TEMPERATURE, Picture, picture
from tests.unit.plots.test_files import pdf_text
from tests.unit.plots.test_selections import require_unlike_entries

#: Pictures that the fast tests look at; the others are looked at when there is time.
FAST = {("whole", "house"), ("12 members", "house"), ("losses", "house"), ("whole", "dark")}
every_function = pytest.mark.parametrize("name", rm.plot.__all__)


def cases(*, styles: tuple[str, ...] = tuple(pictures.STYLES)) -> list[Any]:
    return [
        pytest.param(
            name, variant, looks_of, id=f"{name}-{variant}-{looks_of}",
            marks=[] if (variant, looks_of) in FAST else [pytest.mark.slow],
        )
        for name in rm.plot.__all__
        for variant in pictures.VARIANTS
        for looks_of in styles
        if looks_of == "house" or variant in {"whole", "12 members", "12 words", "losses"}
    ]  # fmt: skip


every_picture = pytest.mark.parametrize(("name", "variant", "looks_of"), cases())
every_house_picture = pytest.mark.parametrize(
    ("name", "variant", "looks_of"), cases(styles=("house",))
)


def drawn(name: str, variant: str, looks_of: str) -> Picture:
    found = picture(name, variant, looks_of)
    if found is None:
        pytest.skip("this function has no such result, or refuses it in words")
    return found


def lines_of(shown: Picture) -> list[Line2D]:
    return [artist for artist in shown.artists if isinstance(artist, Line2D)]


# 1. What is drawn exists.


@every_picture
def test_1_every_point_is_a_number_of_the_result(name: str, variant: str, looks_of: str) -> None:
    """No vertex of a line that is returned lies where the result has no number."""
    shown = drawn(name, variant, looks_of)
    numbers = [array.values for array in shown.dataset.variables.values()]
    known = np.concatenate(
        [np.abs(v).ravel() if v.dtype.kind == "c" else v.ravel().astype(float)
         for v in numbers if v.dtype.kind in "fciu"]
    )  # fmt: skip
    known = np.append(known, 0.0)
    for line in lines_of(shown):
        points = np.asarray(line.get_xydata(), dtype=float)
        points = points[np.isfinite(points).all(axis=1)]
        assert np.isin(points, known).all()


@every_picture
def test_1_every_mark_lies_inside_the_frame(name: str, variant: str, looks_of: str) -> None:
    """Special points, equilibria and resonances are seen whole."""
    axes = drawn(name, variant, looks_of).axes
    (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    for line in axes.lines:
        if line.get_transform() != axes.transData or line.get_marker() in {"None", "", "|"}:
            continue
        for x, y in np.asarray(line.get_xydata(), dtype=float):
            if np.isfinite([x, y]).all():
                assert left <= x <= right
                assert low <= y <= high


# 2. What is missing is named.


@every_function
def test_2_what_is_missing_is_named(name: str) -> None:
    """A lost member, a gap or a cell without an answer has words that a whole result has not."""
    lost = drawn(name, "losses", "house")
    words = r"no result|not measured|not defined|undecided|no equilibrium|without a prediction"
    assert re.search(words, lost.words), lost.words
    assert lost.words != drawn(name, "whole", "house").words


# 3. Colour is an ordered number, or a word with a second cue.


@every_house_picture
def test_3_colour_is_temperature(name: str, variant: str, looks_of: str) -> None:
    """Wherever temperature varies, lines and points have its colours, and no others."""
    shown = drawn(name, variant, looks_of)
    if TEMPERATURE not in shown.dataset.coords or variant.endswith("words"):
        pytest.skip("no temperature")
    kelvins = np.atleast_1d(shown.dataset[TEMPERATURE].values).tolist()
    expected = {tuple(np.round(tone, 6)) for tone in colours.temperature_colours(kelvins)}
    for artist in shown.artists:
        if isinstance(artist, Line2D):
            assert tuple(np.round(to_rgba(artist.get_color())[:3], 6)) in {e[:3] for e in expected}
        elif isinstance(artist, PathCollection):
            assert tuple(np.round(artist.get_facecolor()[0], 6)) in expected


def cues(artist: Any) -> tuple[str, ...]:
    """What tells an artist from others beside its colour."""
    if isinstance(artist, Line2D):
        return (str(artist.get_linestyle()), str(getattr(artist, "_dash_pattern", "")),
                str(artist.get_marker()))  # fmt: skip
    if isinstance(artist, PathCollection):
        # Open or full, and the shape of the first point.
        return (str(len(artist.get_facecolor())), str(artist.get_paths()[0].vertices.shape))
    one = pictures.main_artist(artist)
    return (str(one.get_hatch()),)


@pytest.mark.parametrize("variant", ["2 words", pytest.param("5 words", marks=pytest.mark.slow)])
@every_function
def test_3_words_have_a_second_cue(name: str, variant: str) -> None:
    """Cases of the same colour differ in line style, marker or hatching, and all are told apart."""
    shown = drawn(name, variant, "house")
    if len(shown.artists) != int(variant.split(maxsplit=1)[0]):
        pytest.skip("stability is the line style here, or lines stand for more than one case")
    for one, other in itertools.combinations(shown.artists, 2):
        apart = vision.distances([colour_of(one)], [colour_of(other)], vision.DEUTERANOPIA)
        assert cues(one) != cues(other) or apart[0, 0] >= 20.0


# 4. No two entries of a legend are alike.


@every_picture
def test_4_no_two_entries_look_or_read_the_same(name: str, variant: str, looks_of: str) -> None:
    """Each entry has a name and a look of its own."""
    require_unlike_entries(drawn(name, variant, looks_of).axes)


# 5. Colours can be told apart.


def colour_of(artist: Any) -> Any:
    artist = pictures.main_artist(artist)
    if isinstance(artist, Line2D):
        return to_rgb(artist.get_color())
    colours_ = artist.get_facecolor() if np.size(artist.get_facecolor()) else artist.get_edgecolor()
    return tuple(np.ravel(colours_)[:3])


def luminance(colour: Any) -> float:
    return 1.05 / float(vision.contrast_with_white([colour])[0])


@every_picture
def test_5_lines_stand_out_from_the_ground(name: str, variant: str, looks_of: str) -> None:
    """A contrast of 3 and more, on white and on black."""
    shown = drawn(name, variant, looks_of)
    ground = luminance(shown.axes.get_facecolor())
    for line in lines_of(shown):
        own = luminance(line.get_color())
        assert max(own, ground) / min(own, ground) >= 2.99


@every_picture
def test_5_members_differ_under_deuteranopia_or_in_lightness(
    name: str, variant: str, looks_of: str
) -> None:
    """Neighbours by 20 in colour or 10 in lightness, or in a second cue; many have a bar."""
    shown = drawn(name, variant, looks_of)
    if colour_bars(shown.figure):
        pytest.skip("a colour bar tells the order")
    kinds = {(to_rgb(h.get_color()), str(h.get_linestyle()), str(h.get_marker()))
             for h in legend_handles(shown) if isinstance(h, Line2D)}  # fmt: skip
    for one, other in itertools.combinations(sorted(kinds), 2):
        apart = vision.distances([one[0]], [other[0]], vision.DEUTERANOPIA)[0, 0]
        step = abs(np.diff(vision.lightness([one[0], other[0]]))[0])
        assert one[1:] != other[1:] or apart >= 20.0 or step >= 10.0, (one, other, apart, step)


def legend_handles(shown: Picture) -> list[Any]:
    legend = shown.axes.get_legend()
    return [] if legend is None else list(legend.legend_handles)


# 6. Many members have a colour bar, and a legend takes a quarter of the height at most.


def colour_bars(figure: Figure) -> list[Any]:
    return [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]


@every_picture
def test_6_a_legend_takes_a_quarter_of_the_height(name: str, variant: str, looks_of: str) -> None:
    """In the smallest figure, whatever the style, and it covers nothing that is drawn."""
    shown = drawn(name, variant, looks_of)
    legend = shown.axes.get_legend()
    if legend is None:
        pytest.skip("no legend")
    box, frame = legend.get_window_extent(), shown.axes.get_window_extent()
    assert box.height <= 0.25 * shown.figure.bbox.height
    assert box.y0 >= frame.y1 - 1.0


@pytest.mark.parametrize(
    "variant", ["12 members", pytest.param("7 members", marks=pytest.mark.slow)]
)
@every_function
def test_6_more_than_six_temperatures_have_a_colour_bar(name: str, variant: str) -> None:
    """It goes from the first to the last, and the legend names none of them."""
    shown = drawn(name, variant, "house")
    if name == "overview":
        pytest.skip("it shows five of them")
    (bar,) = colour_bars(shown.figure)
    assert bar.get_ylim() == (250.0, 400.0)
    assert not any("T =" in text for text in shown.legend_texts)


# 7. All text lies inside a small figure and can be read.


def texts_of(figure: Figure) -> Iterator[Text]:
    """Everything that is written, ticks inside their limits only."""
    for text in figure.findobj(Text):
        if isinstance(text, Text) and text.get_visible() and text.get_text().strip():
            yield text
    # Ticks outside the limits of their axis have a label that is not drawn.


def drawn_ticks(figure: Figure) -> set[int]:
    """Labels of ticks that are drawn."""
    axis = [a for axes in figure.axes for a in (axes.xaxis, axes.yaxis)]
    return {
        id(label)
        for one in axis
        for tick in [*one.majorTicks, *one.minorTicks]
        for label in (tick.label1, tick.label2)
    } - {
        id(label)
        for one in axis
        for tick in one._update_ticks()  # type: ignore[attr-defined]
        for label in (tick.label1, tick.label2)
    }


@every_picture
def test_7_all_text_lies_inside(name: str, variant: str, looks_of: str) -> None:
    """At 3.4 by 2.5 inches nothing is cut, in no style."""
    figure = drawn(name, variant, looks_of).figure
    hidden = drawn_ticks(figure)
    width, height = figure.bbox.width, figure.bbox.height
    for text in texts_of(figure):
        if id(text) in hidden:
            continue
        box = text.get_window_extent()
        assert box.x0 >= -1.0, text.get_text()
        assert box.y0 >= -1.0, text.get_text()
        assert box.x1 <= width + 1.0, text.get_text()
        assert box.y1 <= height + 1.0, text.get_text()


@every_house_picture
def test_7_letters_have_6_to_8_5_points(name: str, variant: str, looks_of: str) -> None:
    """As a journal prints them."""
    for text in texts_of(drawn(name, variant, looks_of).figure):
        assert 6.0 <= text.get_fontsize() <= 8.5, text.get_text()


# 8. Files have TrueType fonts and fine pixels.

one_or_all = [
    pytest.param(name, marks=[] if name == "section" else [pytest.mark.slow])
    for name in rm.plot.__all__
]


def own_figure(name: str) -> Figure:
    """The figure that a function makes by itself."""
    dataset = pictures.result_of(name)
    found = pictures.drawing_of(name)(dataset, **pictures.more_of(name, dataset))
    first = pictures.main_artist(found[0] if isinstance(found, list) else found)
    figure = first.get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure


@pytest.mark.parametrize("name", one_or_all)
def test_8_pyplot_saves_true_type_fonts_and_600_dots_an_inch(name: str) -> None:
    """No Type 3 font in a PDF, and 600 pixels of an image for each inch that it covers."""
    own_figure(name)
    buffer = io.BytesIO()
    plt.savefig(buffer, format="pdf")
    text = pdf_text(buffer.getvalue())
    assert b"/FontFile2" in text
    assert b"/Type3" not in text
    placed = re.findall(rb"([\d.]+) 0 0 ([\d.]+) \S+ \S+ cm\s*/(I\d+) Do", text)
    widths = [int(n) for n in re.findall(rb"/Subtype /Image[^>]*?/Width (\d+)", text)] or [
        int(n) for n in re.findall(rb"/Width (\d+)", text)
    ]
    for (points, _, _), pixels in zip(placed, widths, strict=False):
        assert pixels >= 0.98 * 600.0 * float(points) / 72.0


@pytest.mark.parametrize("name", one_or_all)
def test_8_pyplot_saves_300_dots_an_inch(name: str) -> None:
    """Of a PNG, by whatever call."""
    figure = own_figure(name)
    buffer = io.BytesIO()
    plt.savefig(buffer, format="png")
    buffer.seek(0)
    assert plt.imread(buffer).shape[1] == int(300 * figure.get_figwidth())


# 9. The user's axes stay as they were.


@every_function
def test_9_axes_of_a_user_stay_as_they_were(name: str) -> None:
    """Title, labels, ground, fonts, limits of style and what was drawn and named before."""
    before = dict(mpl.rcParams)
    figure, axes = plt.subplots(figsize=(4.0, 3.0), layout="constrained")
    axes.set(title="my title", xlabel="my x", ylabel="my y", facecolor="#eef4ff")
    mine = axes.plot([0.5, 1.0], [0.2, 0.8], color="#123456", linewidth=3.0, label="mine")[0]
    axes.legend()
    dataset = pictures.result_of(name)
    pictures.drawing_of(name)(dataset, **pictures.more_of(name, dataset), ax=axes)
    figure.draw_without_rendering()
    assert dict(mpl.rcParams) == before
    assert (axes.get_title(), axes.get_xlabel(), axes.get_ylabel()) == ("my title", "my x", "my y")
    assert axes.get_facecolor() == to_rgba("#eef4ff")
    assert axes.lines[0] is mine
    assert (mine.get_color(), mine.get_linewidth()) == ("#123456", 3.0)
    legend = axes.get_legend()
    assert legend is not None
    assert "mine" in [text.get_text() for text in legend.get_texts()]
    for text in texts_of(figure):
        assert text.get_fontname() == "DejaVu Sans", text.get_text()


@every_function
def test_9_a_second_picture_adds_to_the_legend(name: str) -> None:
    """Entries of the first one are still there."""
    shown = drawn(name, "whole", "house")
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0.5, 1.0], [0.2, 0.8], "k:", label="mine")
    axes.legend()
    for _ in range(2):
        pictures.drawing_of(name)(shown.dataset, **pictures.more_of(name, shown.dataset), ax=axes)
    legend = axes.get_legend()
    assert legend is not None
    names = [text.get_text() for text in legend.get_texts()]
    assert {"mine", *shown.legend_texts} == set(names)
    assert len(set(names)) == len(names)


# 10. Axes say meaning, symbol and unit.

#: Meaning, symbol and unit; where there is no room, symbol and unit.
LABEL = re.compile(r"^([a-zA-Z][^$]*, )?\$[^$]+\$( \(.+\))?$")


@every_picture
def test_10_axes_say_meaning_symbol_and_unit(name: str, variant: str, looks_of: str) -> None:
    """Of colour bars too."""
    shown = drawn(name, variant, looks_of)
    labels = [shown.axes.get_xlabel(), shown.axes.get_ylabel()]
    labels += [bar.get_ylabel() for bar in colour_bars(shown.figure)]
    for label in filter(None, labels):
        plain = label.replace("\n", " ").replace("quasi-periodic: ", "").replace("chaotic: ", "")
        assert LABEL.match(
            plain.replace("number $", "number, $").replace("exponent $", "exponent, $")
        ), label
    assert labels[0]


@every_function
def test_10_the_footer_is_no_code(name: str) -> None:
    """No quotation mark, no keyword argument, no name with an underscore."""
    text = re.sub(r"\$[^$]*\$", "", footer_text(pictures.result_of(name)))
    assert not re.search(r"['\"_]|\w=\w", text), text
