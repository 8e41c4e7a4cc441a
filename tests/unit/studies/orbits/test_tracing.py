"""Branches of orbits with their special points."""

from __future__ import annotations

import numpy as np

import remanent as rm
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._tracing import TracingOptions, trace_all_branches


def test_special_points_lie_between_the_points_of_the_branch_that_they_name() -> None:
    """Law: the way over one is that from point to point, but for the curvature.

    A branch of twice the period ends at the doubling where the orbit of one period loses its
    stability.
    """
    ens = lay_out_ensemble(rm.Actuator(dissipation=rm.Rayleigh(0.01)), rm.SineSquared(0.8, 2.4))
    options = TracingOptions("omega", (2.31, 2.34), None, 2, 400, 1e-9).require_valid(ens)
    tracing = options.tracing_of_member(ens)
    (branch,), _ = trace_all_branches(tracing, 1)
    assert branch.curve.end_reasons == ("bounds", "branching")
    assert [one.kind for one in branch.special_points] == ["period doubling"]
    assert branch.joins_shorter_period == [True]
    points, scale = branch.curve.points.unknown, tracing.scale
    for one in branch.special_points:
        before, after = points[one.segment_index : one.segment_index + 2] / scale
        here = one.point.unknown[0] / scale
        way = np.linalg.norm(here - before) + np.linalg.norm(after - here)
        assert way < 1.01 * np.linalg.norm(after - before)
    forced = rm.continue_orbit(ens.system, ens.drive, "omega", (2.31, 2.45))
    (doubling,) = branch.special_points
    away = abs(doubling.point.unknown[0, -1] - float(forced.special_omega[0]))
    assert away <= float(forced.special_error[0]) + doubling.parameter_error
