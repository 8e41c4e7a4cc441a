"""What colours, line styles and markers of an ensemble mean: legend entries and colour bars."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D

from remanent.plots import colour_bars, colours, missing, style
from remanent.plots.ensemble import Member

__all__ = ["add_colour_bar", "has_colour_bar", "line_legend_entries", "point_legend_entries"]

#: Most lost members that are named one by one.
_MAX_LOST_COUNT: Final = 4


def line_legend_entries(drawn: Sequence[Member], *variables: str) -> list[Line2D]:
    """Legend entries of lines: one per colour and, where they differ too, one per line style.

    Parameters
    ----------
    drawn : sequence of Member
        In the order they were drawn.
    *variables : str
        What was drawn; members without a value of one of them are named so.

    Returns
    -------
    list of matplotlib.lines.Line2D
        Empty for a single member without a name.
    """

    def sample(colour: Any, member: Member, label: str) -> Line2D:
        own: Any = member.line_style if _tells_by_style(colour, member) else "-"
        return Line2D([], [], color=colour, linestyle=own, label=label)

    return _entries(drawn, variables, sample)


def point_legend_entries(drawn: Sequence[Member], *variables: str) -> list[Line2D]:
    """Legend entries of points: one per colour and, where they differ too, one per marker."""

    def sample(colour: Any, member: Member, label: str) -> Line2D:
        own = member.marker if _tells_by_style(colour, member) else "o"
        inside = "none" if member.word_number == 0 and not member.style_label else colour
        return Line2D([], [], color=colour, linestyle="", ms=3.5, label=label, marker=own,
                      mfc=inside)  # fmt: skip

    return _entries(drawn, variables, sample)


def has_colour_bar(drawn: Sequence[Member]) -> bool:
    """Whether colours stand for so many numbers that a bar says more than names do."""
    numbers = {member.number for member in drawn if member.number is not None}
    return len(numbers) > colours.MAX_NAMED_NUMBER_COUNT


def add_colour_bar(axes: Axes, drawn: Sequence[Member]) -> None:
    """Add the colour bar of an ensemble where it has one, see :func:`has_colour_bar`.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What was drawn in.
    drawn : sequence of Member
        In any order.
    """
    scale = drawn[0].scale if drawn else None
    if scale is None or not has_colour_bar(drawn):
        return
    source = ScalarMappable(scale.normalisation, scale.colour_map)
    bar = colour_bars.add_colour_bar(axes, source, scale.name)
    numbers = [member.number for member in drawn if member.number is not None]
    bar.ax.set_ylim(min(numbers), max(numbers))


def _entries(
    drawn: Sequence[Member],
    variables: tuple[str, ...],
    sample: Callable[[Any, Member, str], Line2D],
) -> list[Line2D]:
    """Entries of each colour, of each style where there are several, and of lost members."""
    by_colour = _grouped(drawn, "colour_label")
    by_style = _grouped(drawn, "style_label")
    named = {} if has_colour_bar(drawn) else by_colour
    lost = [member for member in drawn if not missing.has_values(member, *variables)]
    entries = [
        sample(group[0].colour, group[0], label + _nothing_suffix(group, lost))
        for label, group in named.items()
    ]
    if len(by_style) > 1:
        ink = style.ink_colour()
        entries += [
            sample(ink, group[0], label + _nothing_suffix(group, lost))
            for label, group in by_style.items()
        ]
    whole = [*named.values(), *(by_style.values() if len(by_style) > 1 else ())]
    return entries + _lost_entries(lost, whole)


def _grouped(drawn: Sequence[Member], attribute: str) -> dict[str, list[Member]]:
    """Members by their name of colour or of style; those without one are left out."""
    groups: dict[str, list[Member]] = {}
    for member in drawn:
        if getattr(member, attribute):
            groups.setdefault(getattr(member, attribute), []).append(member)
    return groups


def _tells_by_style(colour: Any, member: Member) -> bool:
    """Whether an entry shows the member's own line style or marker."""
    return bool(colour == style.ink_colour()) or not member.style_label


def _nothing_suffix(group: Sequence[Member], lost: Sequence[Member]) -> str:
    """What is said after the name of a group of which there is nothing to see."""
    if not all(any(member is one for one in lost) for member in group):
        return ""
    return f" ({missing.why_missing(group[0])})"


def _lost_entries(lost: Sequence[Member], groups: Sequence[Sequence[Member]]) -> list[Line2D]:
    """Entries of lost members whose colour and style others of the ensemble still show."""
    said = {
        id(member)
        for group in groups
        if all(any(one is other for other in lost) for one in group)
        for member in group
    }
    alone = [member for member in lost if id(member) not in said and member.label]
    labels = [f"{member.label} ({missing.why_missing(member)})" for member in alone]
    if len(alone) > _MAX_LOST_COUNT:
        words = ", ".join(dict.fromkeys(missing.why_missing(member) for member in alone))
        labels = [f"{len(alone)} of them: {words}"]
    return [Line2D([], [], linestyle="", marker="", label=label) for label in labels]
