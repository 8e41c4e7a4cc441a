"""The symbolic derivation: energies, Lagrange's equations, a first-order system."""
