"""Verbs for one motion: histories, sections, balances."""
