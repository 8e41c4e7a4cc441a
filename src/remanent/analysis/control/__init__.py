"""Commands after which a system is at rest, and when an answer settles."""
