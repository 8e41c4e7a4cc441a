"""Commands after which a system is at rest, and when a step response settles."""
