"""Materials: strain energies of incompressible solids."""
