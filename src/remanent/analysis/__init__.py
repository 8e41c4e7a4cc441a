"""Mathematics of motions: arrays and maps in, arrays out, tested on systems with known answers.

The rooms are those of `studies`, so the arithmetic behind a verb stands in the room of the
same name.  Only `regimes` needs another room: `orbits`.
"""
