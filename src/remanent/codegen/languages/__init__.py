"""Equations of motion as source text in the languages of other tools."""
