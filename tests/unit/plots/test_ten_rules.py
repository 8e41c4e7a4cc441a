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

#: Functions that the fast tests look at closely: lines, branches, points and cells.  Of the others
#: they look at one picture, where its result is at hand.
CLOSELY = {"response", "branch", "section", "map"}
#: Functions whose results take a while to compute.
SLOWLY = {"bars", "energy_balance", "step_response"}
#: Variants and styles that the fast tests look at; all are looked at when there is time.
FAST = [("whole", "house"), ("12 members", "house"), ("losses", "house"), ("whole", "dark")]
EVERY = [
    (variant, looks_of)
    for variant in pictures.VARIANTS
    for looks_of in pictures.STYLES
    if looks_of == "house" or variant in {"whole", "12 members", "12 words", "losses"}
]


def slow_if(is_slow: bool) -> list[pytest.MarkDecorator]:
    """The mark of a test that runs only when there is time."""
    return [pytest.mark.slow] if is_slow else []


every_function = pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=slow_if(name not in CLOSELY)) for name in rm.plot.__all__],
)
every_picture = pytest.mark.parametrize(
    ("name", "kinds"),
    [
        pytest.param(name, kinds, id=f"{name}-{how}", marks=marks)
        for name in rm.plot.__all__
        for kinds, how, marks in (
            (FAST if name in CLOSELY else FAST[:1], "some", slow_if(name in SLOWLY)),
            (EVERY, "all", slow_if(True)),
        )
    ],
)
Kinds = list[tuple[str, str]]


def shown(name: str, kinds: Kinds) -> Iterator[Picture]:
    """The pictures of a function; variants that its result has not are left out."""
    found = (picture(name, *kind) for kind in kinds)
    return (one for one in found if one is not None)


def drawn(name: str, variant: str = "whole") -> Picture:
    found = picture(name, variant, "house")
    if found is None:
        pytest.skip("its result has no such variant, or it refuses it in words")
    return found


def lines_of(picture_: Picture) -> list[Line2D]:
    return [artist for artist in picture_.artists if isinstance(artist, Line2D)]


# 1. What is drawn exists.


@every_picture
def test_1_every_point_is_a_number_of_the_result(name: str, kinds: Kinds) -> None:
    """No vertex of a line that is returned lies where the result has no number."""
    for one in shown(name, kinds):
        numbers = (v.values.ravel() for v in one.dataset.variables.values())
        known = [np.abs(v) if v.dtype.kind == "c" else v for v in numbers if v.dtype.kind in "fciu"]
        for line in lines_of(one):
            points = np.asarray(line.get_xydata(), dtype=float)
            points = points[np.isfinite(points).all(axis=1)]
            assert np.isin(points, np.concatenate([*known, [0.0]])).all(), one.title


@every_picture
def test_1_every_mark_lies_inside_the_frame(name: str, kinds: Kinds) -> None:
    """Special points, equilibria and resonances are in view."""
    for one in shown(name, kinds):
        axes = one.axes
        low, high = np.sort([axes.get_xlim(), axes.get_ylim()], axis=1).T
        for line in axes.lines:
            if line.get_transform() != axes.transData or line.get_marker() in {"None", "", "|"}:
                continue
            places = np.asarray(line.get_xydata(), dtype=float)
            places = places[np.isfinite(places).all(axis=1)]
            assert ((places >= low) & (places <= high)).all(), one.title


# 2. What is missing is named.


@every_function
def test_2_what_is_missing_is_named(name: str) -> None:
    """A lost member, a gap or a cell without an answer has words that a whole result has not."""
    lost, whole = drawn(name, "losses").words, drawn(name).words
    words = r"no result|not measured|not defined|undecided|no equilibrium|without a prediction"
    assert re.search(words, lost), lost
    assert lost != whole


# 3. Colour is an ordered number, or a word with a second cue.


@every_picture
def test_3_colour_is_temperature(name: str, kinds: Kinds) -> None:
    """Wherever temperature is known, lines and points have its colours, and no others."""
    for one in shown(name, [kind for kind in kinds if kind[1] == "house"]):
        if TEMPERATURE not in one.dataset.coords:
            continue
        kelvins = np.atleast_1d(one.dataset[TEMPERATURE].values).tolist()
        expected = np.array([tone[:3] for tone in colours.temperature_colours(kelvins)])
        for artist in one.artists:
            apart = np.abs(expected - np.array(colour_of(artist))).max(axis=1)
            assert apart.min() < 1e-6, one.title


def cues(artist: Any) -> tuple[str, ...]:
    """What tells an artist from others beside its colour."""
    if isinstance(artist, Line2D):
        return (str(artist.get_linestyle()), str(getattr(artist, "_dash_pattern", "")),
                str(artist.get_marker()))  # fmt: skip
    if isinstance(artist, PathCollection):
        # Open or full, and the shape of the first point.
        outline = np.asarray(artist.get_paths()[0].vertices)
        return (str(len(artist.get_facecolor())), str(np.round(outline, 3).tolist()))
    return (str(pictures.main_artist(artist).get_hatch()),)


@pytest.mark.parametrize("count", [2, pytest.param(5, marks=pytest.mark.slow)])
@every_function
def test_3_words_have_a_second_cue(name: str, count: int) -> None:
    """Any two cases differ in line style, marker or hatching, or by 20 in colour."""
    one = drawn(name, f"{count} words")
    if len(one.artists) != count:
        pytest.skip("stability is the line style here, or there are several lines for a case")
    for first, second in itertools.combinations(one.artists, 2):
        apart = vision.distances([colour_of(first)], [colour_of(second)], vision.DEUTERANOPIA)
        assert cues(first) != cues(second) or apart[0, 0] >= 20.0


# 4. No two entries of a legend are alike.


@every_picture
def test_4_no_two_entries_look_or_read_the_same(name: str, kinds: Kinds) -> None:
    """Each entry has a name and a look of its own."""
    for one in shown(name, kinds):
        require_unlike_entries(one.axes)


# 5. Colours can be told apart.


def colour_of(artist: Any) -> Any:
    artist = pictures.main_artist(artist)
    if isinstance(artist, Line2D):
        return to_rgb(artist.get_color())
    filled = artist.get_facecolor()
    return tuple(np.ravel(filled if np.size(filled) else artist.get_edgecolor())[:3])


def luminance(colour: Any) -> float:
    """Relative luminance with the flare of a screen, whose ratios are contrasts."""
    return 1.05 / float(vision.contrast_with_white([colour])[0])


@every_picture
def test_5_lines_stand_out_from_the_ground(name: str, kinds: Kinds) -> None:
    """A contrast of 3 and more, on white and on black."""
    for one in shown(name, kinds):
        ground = luminance(one.axes.get_facecolor())
        for line in lines_of(one):
            own = luminance(line.get_color())
            assert max(own, ground) / min(own, ground) >= 2.99, one.title


@every_picture
def test_5_entries_differ_for_every_reader(name: str, kinds: Kinds) -> None:
    """By 20 under deuteranopia or 10 in lightness, or in a second cue; a bar tells its order."""
    for one in shown(name, kinds):
        legend = one.axes.get_legend()
        handles = [] if legend is None else legend.legend_handles
        entries = {(to_rgb(h.get_color()), *cues(h)) for h in handles if isinstance(h, Line2D)}
        for (first, *cue), (second, *other) in itertools.combinations(sorted(entries), 2):
            apart = vision.distances([first], [second], vision.DEUTERANOPIA)[0, 0]
            step = abs(np.diff(vision.lightness([first, second]))[0])
            assert cue != other or apart >= 20.0 or step >= 10.0, (one.title, apart, step)


# 6. Many members have a colour bar, and a legend takes a quarter of the height at most.


def colour_bars(figure: Figure) -> list[Any]:
    return [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]


@every_picture
def test_6_a_legend_takes_a_quarter_of_the_height(name: str, kinds: Kinds) -> None:
    """In the smallest figure, whatever the style, and it covers nothing that is drawn."""
    for one in shown(name, kinds):
        legend = one.axes.get_legend()
        if legend is not None:
            box, frame = legend.get_window_extent(), one.axes.get_window_extent()
            assert box.height <= 0.25 * one.figure.bbox.height, one.title
            assert box.y0 >= frame.y1 - 1.0, one.title


@every_function
def test_6_more_than_six_temperatures_have_a_colour_bar(name: str) -> None:
    """It goes from the first to the last, and the legend names none of them."""
    one = drawn(name, "12 members")
    if name == "overview":
        pytest.skip("it shows five of them")
    (bar,) = colour_bars(one.figure)
    assert bar.get_ylim() == (250.0, 400.0)
    assert not any("T =" in text for text in one.legend_texts)


# 7. All text lies inside a small figure and can be read.


def texts_of(figure: Figure) -> list[Text]:
    """Everything that is written."""
    texts = (one for one in figure.findobj(Text) if isinstance(one, Text))
    return [text for text in texts if text.get_visible() and text.get_text().strip()]


@every_picture
def test_7_all_text_lies_inside(name: str, kinds: Kinds) -> None:
    """At 3.4 by 2.5 inches nothing is cut, in no style."""
    for one in shown(name, kinds):
        box, (width, height) = one.figure.get_tightbbox(), one.figure.get_size_inches()
        assert box.x0 >= -0.01, one.title
        assert box.y0 >= -0.01, one.title
        assert box.x1 <= width + 0.01, one.title
        assert box.y1 <= height + 0.01, one.title


@every_picture
def test_7_letters_have_6_to_8_5_points(name: str, kinds: Kinds) -> None:
    """As a journal prints them; those of a user are never smaller than 6."""
    for one in shown(name, kinds):
        largest = 8.5 if one.title.endswith("house") else 12.0
        for text in texts_of(one.figure):
            assert 6.0 <= float(text.get_fontsize()) <= largest, (one.title, text.get_text())


# 8. Files have TrueType fonts and fine pixels.

one_or_all = [pytest.param(name, marks=slow_if(name != "section")) for name in rm.plot.__all__]


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
    """Entries of the first one are still there, and none is there twice."""
    one = drawn(name)
    axes = Figure(figsize=(7.0, 4.0), layout="constrained").add_subplot()
    axes.plot([0.5, 1.0], [0.2, 0.8], "k:", label="mine")
    axes.legend()
    for _ in range(2):
        pictures.drawing_of(name)(one.dataset, **pictures.more_of(name, one.dataset), ax=axes)
    legend = axes.get_legend()
    assert legend is not None
    names = [text.get_text() for text in legend.get_texts()]
    assert sorted(names) == sorted({"mine", *one.legend_texts})


# 10. Axes say meaning, symbol and unit.

#: Meaning, symbol and unit; where there is no room, symbol and unit.
LABEL = re.compile(r"^([a-zA-Z][^$]*, )?\$[^$]+\$( \(.+\))?$")


@every_picture
def test_10_axes_say_meaning_symbol_and_unit(name: str, kinds: Kinds) -> None:
    """Of colour bars too."""
    for one in shown(name, kinds):
        bars = [bar.get_ylabel() for bar in colour_bars(one.figure)]
        for label in filter(None, [one.axes.get_xlabel(), one.axes.get_ylabel(), *bars]):
            assert LABEL.match(label.replace("\n", " ")), (one.title, label)
        assert one.axes.get_xlabel()


@every_function
def test_10_the_footer_is_no_code(name: str) -> None:
    """No quotation mark, no keyword argument, no name with an underscore."""
    text = re.sub(r"\$[^$]*\$", "", footer_text(pictures.result_of(name)))
    assert not re.search(r"['\"_]|\w=\w", text), text
