"""Which effects are known: those of the catalogue, what a simulation may declare, and a user's own while in use."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from camid.effects.base import Effect

_catalogue: dict[str, type[Effect]] = {}
_declarable: dict[str, type[Effect]] = {}


def is_of_the_package(kind: type[Effect]) -> bool:
    """Whether a class belongs to this package, and not to a user."""
    return kind.__module__.partition(".")[0] == __name__.partition(".")[0]


def make_known(kind: type[Effect]) -> None:
    """Let simulations declare an effect, and diagnoses look for it if it is listed."""
    # New mappings: others may be going through the old ones.
    global _catalogue, _declarable  # noqa: PLW0603
    _declarable = {**_declarable, kind.identifier: kind}
    if kind.listed:
        _catalogue = {**_catalogue, kind.identifier: kind}


def forget(kind: type[Effect]) -> None:
    """Undo :func:`make_known`."""
    global _catalogue, _declarable
    _catalogue, _declarable = (
        {name: known for name, known in mapping.items() if known is not kind} for mapping in (_catalogue, _declarable)
    )


def known_effects() -> Mapping[str, type[Effect]]:
    """The effects of the catalogue by identifier, and those of a user's own that are in use."""
    return _catalogue


def declarable_effects() -> Mapping[str, type[Effect]]:
    """All effects that a simulation may declare, by identifier: those of the catalogue, and learned laws."""
    return _declarable
