"""What the page of the report says of its pictures."""

from __future__ import annotations

import re
from importlib.resources import files

from remanent.report.claims import CLAIMS
from remanent.report.drawings import DRAWINGS

TEMPLATE = (files("remanent.report") / "templates" / "report.html").read_text("utf-8")


def test_every_picture_is_told_to_who_does_not_see_it() -> None:
    """Its words say what is seen, which the caption, read out too, does not."""
    shown = re.findall(r'picture\("(\w+)", "([^"]*)",\s*"([^"]*)"\)', TEMPLATE)
    assert sorted(name for name, _, _ in shown) == sorted(DRAWINGS)
    for _, caption, seen in shown:
        assert len(seen) > 80
        assert seen != caption


def test_claims_name_the_figure_that_they_lead_to() -> None:
    """No two figures have the same title, and no claim leads to one without."""
    titles = dict(
        re.findall(r'"(\w+)": "([^"]*)"', TEMPLATE.split("picture_titles = {")[1].split("}")[0])
    )
    assert set(titles) == set(DRAWINGS)
    assert len(set(titles.values())) == len(titles)
    assert {claim.picture_name for claim in CLAIMS} <= set(titles)
