"""What the report holds: the evidence, the verdicts, the data and the pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

from remanent.report.audit import Verdict
from remanent.report.evidence import Evidence


@dataclass(frozen=True)
class Paper:
    """All that was computed to reproduce and audit the article.

    Attributes
    ----------
    evidence : Evidence
        For the reference setting.
    verdicts : list of Verdict
        One for every claim.
    datasets : mapping of str to xarray.Dataset
        The data of the figures, by name.
    pictures : mapping of str to mapping of str to bytes
        The files of each picture, by the picture's name and the file's suffix.
    """

    evidence: Evidence
    verdicts: list[Verdict]
    datasets: Mapping[str, xr.Dataset]
    pictures: Mapping[str, Mapping[str, bytes]]
