"""The server behind ``remanent explore``."""
