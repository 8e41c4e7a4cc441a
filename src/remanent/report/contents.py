"""What the report holds, before it is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

from remanent.report.audit import ClaimVerdict
from remanent.report.evidence import ClaimEvidence


@dataclass(frozen=True)
class Paper:
    """All that was computed.

    Attributes
    ----------
    evidence : ClaimEvidence
        For the reference setting.
    verdicts : list of ClaimVerdict
        Of every claim.
    datasets : mapping of str to xarray.Dataset
        By name.
    pictures : mapping of str to mapping of str to bytes
        Files by name of the picture and suffix.
    """

    evidence: ClaimEvidence
    verdicts: list[ClaimVerdict]
    datasets: Mapping[str, xr.Dataset]
    pictures: Mapping[str, Mapping[str, bytes]]
