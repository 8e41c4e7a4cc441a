"""Verbs for commands."""
