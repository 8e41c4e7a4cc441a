"""Verbs for equilibria."""
