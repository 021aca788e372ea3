"""Files that end too early, recognised by what their containers say about their own length."""

from __future__ import annotations

import os
from pathlib import Path

# A box or a chunk that reaches to the end of the file, whatever its length.
OPEN_ENDED = frozenset({0, 0xFFFFFFFF})
MPEG4_SUFFIXES = frozenset({".mp4", ".m4v", ".mov", ".3gp"})


def lacks_index(path: Path) -> bool:
    """Whether this is an MP4 or QuickTime file without its index, as a recorder leaves it that was switched off."""
    names = [name for name, _, _ in _boxes(path)]
    return bool(names) and (b"ftyp" in names or b"mdat" in names) and b"moov" not in names


def ends_early(path: Path) -> bool:
    """Whether an MP4, QuickTime or AVI file is shorter than its own headers say."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(12)
    if head[:4] == b"RIFF":
        length = int.from_bytes(head[4:8], "little")
        return length not in OPEN_ENDED and length + 8 > size
    return any(start + length > size for _, start, length in _boxes(path))


def _boxes(path: Path) -> list[tuple[bytes, int, int]]:
    """Name, start and length in bytes of the outermost boxes of an MP4 file (ISO/IEC 14496-12, section 4.2)."""
    found: list[tuple[bytes, int, int]] = []
    size = path.stat().st_size
    position = 0
    with path.open("rb") as stream:
        while position + 8 <= size:
            stream.seek(position, os.SEEK_SET)
            head = stream.read(16)
            length, name = int.from_bytes(head[:4], "big"), head[4:8]
            if not name.isalnum():  # no MP4 file at all
                return found
            if length == 1:
                length = int.from_bytes(head[8:16], "big")
            elif length == 0:
                length = size - position
            if length < 8:
                return found
            if not found and name not in {b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"}:
                return []
            found.append((name, position, length))
            position += length
    return found
