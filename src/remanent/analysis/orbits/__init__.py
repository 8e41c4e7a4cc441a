"""Periodic orbits of maps: search, stability, continuation, bifurcations, manifolds."""
