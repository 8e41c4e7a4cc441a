"""Ensembles of trajectories, resolved until the tolerance is met."""
