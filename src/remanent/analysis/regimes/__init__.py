"""What kind of motion an orbit is: exponents, indicators, labels, attractors."""
