"""Speed, beside the peers, in one run; run with ``python -m benchmarks``."""
