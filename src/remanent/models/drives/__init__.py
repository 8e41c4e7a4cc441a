"""Drives: the magnetic load as a function of time."""
