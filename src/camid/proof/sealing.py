"""Seals: proof that the truths were fixed before any diagnosis was made, and not altered after.

A seal is the SHA-256 digest of a salt, the truth and the files of a recording. Published before the diagnoses, it says
nothing of the truth; with the salt revealed anybody can compute it again. It is the commitment by a hash function with
a nonce (Halevi & Micali, *Practical and Provably-Secure Commitment Schemes from Collision-Free Hashing*, CRYPTO 1996).
"""

from __future__ import annotations

import hashlib
import json
import secrets
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

SALT_BYTES = 32


class BrokenSealError(ValueError):
    """A truth or a file of a recording is not what was sealed."""


def new_salt() -> str:
    """256 random bits from the operating system, in hexadecimal digits.

    The salt is a nonce and not a number of a model: no result depends on it, so it has no seed. Without it, a truth
    with few possible values could be guessed and the guess checked against the published seal.
    """
    return secrets.token_hex(SALT_BYTES)


def canonical(truth: Mapping[str, Any]) -> bytes:
    """Canonical form of a truth: JSON with sorted keys, no blanks, UTF-8, as RFC 8785 except for the digits of numbers.

    Raises
    ------
    ValueError
        If a number is not finite, which JSON cannot say.
    """
    text = json.dumps(truth, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return text.encode("utf-8")


def digest_of_files(files: Iterable[Path]) -> bytes:
    """SHA-256 of the names and contents of files, in the order given."""
    digest = hashlib.sha256()
    for file in files:
        for part in (file.name.encode("utf-8"), file.read_bytes()):
            # The length in front keeps a byte from passing from one part to the next unnoticed.
            digest.update(len(part).to_bytes(8, "big"))
            digest.update(part)
    return digest.digest()


def seal(salt: str, truth: Mapping[str, Any], files: Iterable[Path]) -> str:
    """The seal of one recording.

    Parameters
    ----------
    salt : str
        Hexadecimal digits, from :func:`new_salt`.
    truth : mapping
        What is concealed.
    files : iterable of path
        Recording, simulation and held-out recordings, always in the same order.

    Returns
    -------
    str
        64 hexadecimal digits: SHA-256(salt ‖ canonical truth ‖ digest of the files).
    """
    return hashlib.sha256(bytes.fromhex(salt) + canonical(truth) + digest_of_files(files)).hexdigest()


def check_seal(index: int, published: str, salt: str, truth: Mapping[str, Any], files: Iterable[Path]) -> None:
    """Refuse a recording whose seal is not the published one.

    Raises
    ------
    BrokenSealError
        With the index of the recording.
    """
    if not secrets.compare_digest(published, seal(salt, truth, files)):
        raise BrokenSealError(
            f"the seal of recording {index} is broken: its truth or its files are not those that were sealed"
        )
