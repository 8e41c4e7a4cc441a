"""Largest values of a response, and the harmonic that resonates."""
