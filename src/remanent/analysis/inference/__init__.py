"""Parameters from data, and what uncertain parameters make of a result."""
