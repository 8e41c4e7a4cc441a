"""What is measured: each file has a tuple ``ROWS``, and is found by being here."""
