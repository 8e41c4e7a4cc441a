"""Where a static force vanishes."""
