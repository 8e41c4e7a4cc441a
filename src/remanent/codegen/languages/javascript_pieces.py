"""The pieces of a load in time, in JavaScript."""

from __future__ import annotations

from typing import Final

#: The number of the piece that holds a time, by bisection.
PIECE_AT: Final = """\
/** The number of the piece that holds a time; 0 before the first, and where there is none. */
function pieceAt(t) {
  let low = 0;
  let high = pieces.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (pieces[middle][0] <= t) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}"""
