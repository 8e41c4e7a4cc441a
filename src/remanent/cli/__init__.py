"""The command `remanent`: parse, call one verb, present."""
