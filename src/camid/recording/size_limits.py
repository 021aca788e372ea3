"""How much a recording may hold, whatever its file says: a few kilobytes may unpack to more than any memory.

The limits are far above any recording of a machine; ten million rows of three columns take a quarter of them.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from camid.errors import InputError

if TYPE_CHECKING:
    import h5py

# Of text, unpacked, and of numbers in memory.
MOST_BYTES = 2**30
# Of a line of text, in characters, and of a table.
LONGEST_LINE, MOST_COLUMNS = 1_000_000, 10_000
# Of an HDF5 file: links may lead in circles, and to the same group again and again.
MOST_NODES, DEEPEST = 20_000, 50
# MAT of versions 5 to 7.2: header, and the type of a compressed element.
MAT_HEADER, MAT_COMPRESSED = 128, 15
CHUNK = 2**20


def refuse_no_file(path: Path, name: str) -> None:
    """Refuse a device or a pipe, from which reading may never end."""
    if path.exists() and not path.is_file():
        raise InputError("this is a device or a pipe", where=name, hint="name a file")


def refuse_size(size: int, name: str) -> None:
    """Refuse more bytes than a recording may have."""
    if size > MOST_BYTES:
        raise InputError(
            f"more than {MOST_BYTES / 2**20:.4g} MiB of data",
            where=name,
            hint="cut it, or leave out columns and rows",
        )


def read_at_most(stream: IO[bytes], name: str) -> bytes:
    """All bytes of a stream that unpacks a file.

    Raises
    ------
    InputError
        If there are more than a recording may have; the others are not unpacked.
    """
    data = stream.read(MOST_BYTES + 1)
    refuse_size(len(data), name)
    return data


def refuse_long_lines(text: str, name: str) -> None:
    """Refuse a line that is none of a table."""
    start = 0
    while len(text) - start > LONGEST_LINE:
        window = start, start + LONGEST_LINE
        end = max(text.rfind("\n", *window), text.rfind("\r", *window))
        if end < 0:
            line = text.count("\n", 0, start) + 1
            hint = "is it a table with one row in each line, and is each quotation mark closed?"
            where = f"{name}, line {line}"
            raise InputError(f"a line of more than {LONGEST_LINE:,} characters", where=where, hint=hint)
        start = end + 1


def refuse_many_columns(count: int, name: str) -> None:
    """Refuse a table with more columns than any recording."""
    if count > MOST_COLUMNS:
        raise InputError(f"{count:,} columns", where=name, hint=f"at most {MOST_COLUMNS:,} are read: leave some out")


def refuse_unpacking_mat(path: Path) -> None:
    """Refuse a MAT file of versions 5 to 7.2 whose compressed variables unpack to more than a recording may have."""
    total = 0
    with path.open("rb") as file:
        header = file.read(MAT_HEADER)
        order: Any = "big" if header[126:128] == b"MI" else "little"
        while len(tag := file.read(8)) == 8:
            kind, size = (int.from_bytes(tag[i : i + 4], order) for i in (0, 4))
            after = file.tell() + size
            if kind == MAT_COMPRESSED:
                total += _unpacked(file, size, MOST_BYTES - total)
                refuse_size(total, str(path))
            file.seek(after)


def _unpacked(file: IO[bytes], size: int, most: int) -> int:
    """Number of bytes that a zlib stream in a file unpacks to; counting ends beyond ``most``."""
    unpacking, total = zlib.decompressobj(), 0
    while size > 0 and total <= most and not unpacking.eof:
        packed = file.read(min(size, CHUNK))
        if not packed:
            break
        size -= len(packed)
        while packed and total <= most:
            total += len(unpacking.decompress(packed, CHUNK))
            packed = unpacking.unconsumed_tail
    return total


def refuse_hdf5(file: h5py.File, name: str) -> None:
    """Refuse an HDF5 file that leads to other files or in circles, or holds more than a recording may have."""
    import h5py
    import numpy as np

    waiting, nodes, total = [(file, 0)], 0, 0
    while waiting:
        group, depth = waiting.pop()
        for key in group:
            nodes += 1
            where = f"{name}, {key}"
            if isinstance(group.get(key, getlink=True), h5py.ExternalLink):
                raise InputError("a link to another file", where=where, hint="copy what is there into this file")
            if nodes > MOST_NODES or depth > DEEPEST:
                raise InputError("groups without end", where=where, hint="remove links from a group to one around it")
            node = group.get(key)  # None where a link leads nowhere
            if isinstance(node, h5py.Group):
                waiting.append((node, depth + 1))
            elif isinstance(node, h5py.Dataset) and node.shape is not None:
                if node.is_virtual or node.external:
                    raise InputError("its values are in another file", where=where, hint="copy them into this file")
                total += int(np.prod(node.shape, dtype=object)) * max(node.dtype.itemsize, 1)
                refuse_size(total, where)
