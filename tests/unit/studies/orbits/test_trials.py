"""Which points of a search are computed with finer steps."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._typing import IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.studies.orbits._planar_search import groups_to_try

#: Points, and the resolution at which those without an image are too many to try unseen.
COUNT, FINEST = 5000, 10_000


def tried(known: IntArray, found: bool) -> list[IntArray]:
    """Groups of all points, of which some have an image, and others get one or do not."""
    sample = Sample.unknown(COUNT, 2, 2)
    sample.error[known] = 1e-3
    groups = []
    for group in groups_to_try(sample, np.arange(COUNT), FINEST):
        groups.append(group)
        if found:
            sample.error[group] = 1e-6
    return groups


@pytest.mark.parametrize("known", [np.arange(0), np.arange(0, COUNT, 7), np.arange(COUNT)])
def test_every_point_is_tried_once_where_trials_have_an_image(known: IntArray) -> None:
    """Nothing is left out, and nothing computed twice."""
    together = np.concatenate(tried(known, found=True))
    assert np.sort(together).tolist() == list(range(COUNT))


@pytest.mark.parametrize("known", [np.arange(0), np.arange(0, COUNT, 7)])
def test_where_no_trial_has_an_image_the_others_are_left(known: IntArray) -> None:
    """Those that have an image are computed, and a few of the others."""
    together = np.concatenate(tried(known, found=False))
    assert np.isin(known, together).all()
    assert len(known) < len(together) < len(known) + 200
