"""What the report holds: the evidence, the verdicts, the data and the pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

from remanent.report.audit import ClaimVerdict
from remanent.report.evidence import ClaimEvidence


@dataclass(frozen=True)
class Paper:
    """All that was computed to reproduce and audit the article.

    Attributes
    ----------
    evidence : ClaimEvidence
        For the reference setting.
    verdicts : list of ClaimVerdict
        One for every claim.
    datasets : mapping of str to xarray.Dataset
        The data of the figures, by name.
    pictures : mapping of str to mapping of str to bytes
        The files of each picture, by the picture's name and the file's suffix.
    """

    evidence: ClaimEvidence
    verdicts: list[ClaimVerdict]
    datasets: Mapping[str, xr.Dataset]
    pictures: Mapping[str, Mapping[str, bytes]]
