"""Verbs for forced response."""
