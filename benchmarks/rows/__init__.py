"""One file for each group of rows; ``measure(settings)`` gives plain data for JSON."""
