"""Every error that a result carries, beside the true one; run ``python -m benchmarks.errors``."""
