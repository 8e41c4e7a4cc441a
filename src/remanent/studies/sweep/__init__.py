"""Studies: a verb on a grid, in tiles, in memory or in a store that a later run completes."""
