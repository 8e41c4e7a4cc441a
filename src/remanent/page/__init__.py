"""A live page from systems and results: its description, its files, and one file of it all."""
