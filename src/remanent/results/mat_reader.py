"""MAT files of any origin, read without trust.

SciPy's reader takes the sizes that a file states for granted: a file in which a few bytes are
damaged can end the whole process.  This one checks each size before it uses it, reads numbers
and text only, and runs nothing.

The format is that of "MAT-File Level 5" in The MathWorks, MAT-File Format (R2024a): a header of
128 bytes, then elements, each with a tag that says its type and its length in bytes.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from remanent._errors import InputError, error_sentence, shortened_repr

__all__ = ["MatContents", "read_mat"]

_HEADER_BYTES: Final = 128
#: Most bytes that a file may have, compressed or not.
_MAX_BYTES: Final = 2**31
#: How deep cells may lie within cells.
_MAX_DEPTH: Final = 8
#: Byte order by the last two bytes of the header.
_BYTE_ORDERS: Final[Mapping[bytes, str]] = MappingProxyType({b"IM": "<", b"MI": ">"})
#: Types of elements that are no numbers.
_MATRIX_TYPE: Final = 14
_COMPRESSED_TYPE: Final = 15
#: NumPy's types of the numbers in elements, by the type of the element.
_NUMBER_TYPES: Final[Mapping[int, str]] = MappingProxyType(
    {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
)
#: Encodings of elements of text, but for the byte order.
_TEXT_ENCODINGS: Final[Mapping[int, str]] = MappingProxyType(
    {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
)
#: Classes of matrices: cells and characters, and NumPy's types of those of numbers.
_CELL_CLASS: Final = 1
_CHARACTER_CLASS: Final = 4
_NUMBER_CLASSES: Final[Mapping[int, str]] = MappingProxyType(
    {6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8",
     15: "u8"}
)  # fmt: skip
#: Bits of a matrix's flags.
_COMPLEX_FLAG: Final = 0x08
_LOGICAL_FLAG: Final = 0x02


@dataclass(frozen=True)
class MatContents:
    """What a MAT file holds.

    Attributes
    ----------
    arrays : mapping of name to array
        Variables of numbers, truth values or text, rows of characters as one text each; a cell
        array of texts is an array of them.
    other_names : tuple of str
        Names of the other variables: structures, objects, functions, sparse matrices.
    """

    arrays: Mapping[str, NDArray[Any]]
    other_names: tuple[str, ...]


class _DamagedError(Exception):
    """The file is not what it says."""


@dataclass(frozen=True)
class _Matrix:
    """A variable; `array` is None where it is of a class that is not read."""

    name: str
    array: NDArray[Any] | None


def read_mat(path: Path, argument: str = "path") -> MatContents:
    """Read a MAT file of version 5 to 7.2.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    argument : str
        What the message calls it.

    Raises
    ------
    InputError
        A file that cannot be read, is of another version, or is damaged.
    """
    try:
        matrices = _read_matrices(path.read_bytes())
    except (OSError, ValueError, OverflowError, _DamagedError, zlib.error) as error:
        raise InputError(
            argument,
            must="be a readable MAT file",
            got=shortened_repr(str(path)),
            why=error_sentence(error),
            fix="Check the path and the file; save MAT files with the option -v7.",
        ) from error
    return MatContents(
        {m.name: m.array for m in matrices if m.array is not None},
        tuple(m.name for m in matrices if m.array is None),
    )


def _read_matrices(data: bytes) -> list[_Matrix]:
    order = _BYTE_ORDERS.get(data[126:128])
    version = data[124:126] if order == ">" else data[125:123:-1]
    if order is None or version != b"\x01\x00" or len(data) > _MAX_BYTES:
        raise _DamagedError("It is not of version 5 to 7.2")
    matrices = []
    for kind, content in _elements(memoryview(data)[_HEADER_BYTES:], order):
        inner = [(kind, content)]
        if kind == _COMPRESSED_TYPE:
            inner = list(_elements(memoryview(_decompressed(content)), order))
        matrices += [_matrix(c, order, 0) for k, c in inner if k == _MATRIX_TYPE]
    return [matrix for matrix in matrices if matrix.name]


def _decompressed(content: memoryview) -> bytes:
    unpacker = zlib.decompressobj()
    data = unpacker.decompress(content, _MAX_BYTES)
    if not unpacker.eof:
        raise _DamagedError("A compressed part does not end")
    return data


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Type and content of each element."""
    position = 0
    while position + 8 <= len(data):
        kind, size = (int(n) for n in np.frombuffer(data[position : position + 8], f"{order}u4"))
        start = position + 8
        if kind >> 16:  # a small element: length and type share the first half of the tag
            kind, size, start = kind & 0xFFFF, kind >> 16, position + 4
        if start + size > len(data) or (start == position + 4 and size > 4):
            raise _DamagedError("An element is longer than the file")
        yield kind, data[start : start + size]
        padding = 0 if kind == _COMPRESSED_TYPE else -(start + size) % 8
        position = start + size + padding


def _matrix(content: memoryview, order: str, depth: int) -> _Matrix:
    elements = _elements(content, order)
    flags, shape, name = (_next_element(elements) for _ in range(3))
    if depth > _MAX_DEPTH or len(flags[1]) < 8 or shape[0] != 5 or name[0] != 1:
        raise _DamagedError("A variable has no readable description")
    word = int(np.frombuffer(flags[1][:4], f"{order}u4")[0])
    kind, bits = word & 0xFF, word >> 8 & 0xFF
    dims = tuple(int(n) for n in np.frombuffer(shape[1], f"{order}i4"))
    title = bytes(name[1]).decode("latin-1")
    if min(dims, default=-1) < 0 or len(dims) > 32:
        raise _DamagedError(f"`{title}` has no shape")
    if kind == _CELL_CLASS:
        return _Matrix(title, _text_cells(elements, dims, order, depth))
    if kind == _CHARACTER_CLASS:
        return _Matrix(title, _text_rows(_next_element(elements), dims, order))
    if kind not in _NUMBER_CLASSES:
        return _Matrix(title, None)
    array = _numbers(_next_element(elements), dims, order).astype(_NUMBER_CLASSES[kind])
    if bits & _COMPLEX_FLAG:
        imaginary = _numbers(_next_element(elements), dims, order)
        joined = np.empty(dims, dtype=np.result_type(array.dtype, np.complex64))
        joined.real, joined.imag = array, imaginary
        array = joined
    return _Matrix(title, array.astype(np.bool_) if bits & _LOGICAL_FLAG else array)


def _next_element(elements: Iterator[tuple[int, memoryview]]) -> tuple[int, memoryview]:
    element = next(elements, None)
    if element is None:
        raise _DamagedError("A variable ends too early")
    return element


def _numbers(element: tuple[int, memoryview], dims: tuple[int, ...], order: str) -> NDArray[Any]:
    kind, content = element
    if kind not in _NUMBER_TYPES:
        raise _DamagedError(f"Numbers cannot be of type {kind}")
    numbers = np.frombuffer(content, f"{order}{_NUMBER_TYPES[kind]}")
    return numbers.reshape(dims, order="F")


def _text_rows(element: tuple[int, memoryview], dims: tuple[int, ...], order: str) -> NDArray[Any]:
    """A text for each row of characters."""
    kind, content = element
    encoding = _TEXT_ENCODINGS.get(kind)
    if encoding is None or len(dims) != 2:
        raise _DamagedError(f"Text cannot be of type {kind}")
    suffix = ("-le" if order == "<" else "-be") if encoding in {"utf-16", "utf-32"} else ""
    text = bytes(content).decode(f"{encoding}{suffix}")
    if dims[0] <= 1:
        return np.array([text] if text or dims[0] else [], dtype=np.str_)
    letters = np.array(list(text), dtype=np.str_).reshape(dims, order="F")
    return np.array(["".join(row) for row in letters], dtype=np.str_)


def _text_cells(
    elements: Iterator[tuple[int, memoryview]], dims: tuple[int, ...], order: str, depth: int
) -> NDArray[Any] | None:
    """An array of texts; None where a cell holds something else."""
    cells: list[NDArray[Any] | None] = [
        _matrix(c, order, depth + 1).array if len(c) else np.empty(0) for _, c in elements
    ]
    words = [_text_of_cell(cell) for cell in cells]
    if any(word is None for word in words):
        return None
    return np.array(words, dtype=np.str_).reshape(dims, order="F")


def _text_of_cell(cell: NDArray[Any] | None) -> str | None:
    """The text in a cell, nothing where it is empty; None where it holds something else."""
    if cell is None or cell.size > 1 or (cell.size and cell.dtype.kind != "U"):
        return None
    return str(cell.flat[0]) if cell.size else ""
