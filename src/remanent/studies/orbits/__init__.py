"""Verbs for periodic orbits and their branches."""
