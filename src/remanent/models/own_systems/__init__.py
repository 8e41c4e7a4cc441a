"""Systems that a user writes: energies or rates as formulas."""
