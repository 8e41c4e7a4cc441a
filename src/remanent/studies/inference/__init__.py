"""Verbs from data to parameters and back."""
