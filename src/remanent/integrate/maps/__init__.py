"""Maps over drive periods."""
