"""Verbs for long runs: exponents, regimes, basins."""
