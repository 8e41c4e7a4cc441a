"""The report as one self-contained page."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from remanent.report.settings import AGREEMENT, LAWS

if TYPE_CHECKING:
    from remanent.report.paper import Paper

_WORDS = {"supported": "Supported", "contradicted": "Contradicted", "depends": "Depends"}


def render(paper: Paper, summary: Mapping[str, Any], drawings: Mapping[str, str]) -> str:
    """HTML text with every picture inside, readable without a network.

    Parameters
    ----------
    paper
        What was computed.
    summary
        From :func:`remanent.report.paper.summarise`.
    drawings
        SVG text of every figure, by name.
    """
    environment = Environment(
        loader=PackageLoader("remanent.report"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    counts = {word: sum(v.verdict == word for v in paper.verdicts) for word in _WORDS}
    windows = paper.datasets["valley_windows"]["misfit"]
    return environment.get_template("report.html").render(
        summary=summary,
        verdicts=paper.verdicts,
        words=_WORDS,
        counts=counts,
        agreement=AGREEMENT,
        share=float((windows <= AGREEMENT).mean()),
        points=int(windows.size),
        misfits={LAWS[law].text: value for law, value in paper.evidence.misfits.items()},
        drawings={name: _data_address(svg) for name, svg in drawings.items()},
        worst=max(abs(r["difference"]) for r in summary["resonances"]),
        drift=_drifts(paper),
        error=float(paper.evidence.section["error"].max()),
        datasets=sorted(paper.datasets),
    )


def _data_address(svg: str) -> str:
    """An SVG as a data address, on which no script can run and no name can clash."""
    text = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    return "data:image/svg+xml;base64," + base64.b64encode(text.encode()).decode()


def _drifts(paper: Paper) -> dict[str, float]:
    """Largest energy drift of each solver, relative to the depth of motion."""
    drift = abs(paper.datasets["tolerance_energy"]["energy_drift"])
    return {str(name): float(drift.sel(solver=name).max()) for name in drift["solver"].values}
