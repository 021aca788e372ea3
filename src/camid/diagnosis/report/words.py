"""Words of the page: titles of effects where a sentence names an effect by its identifier."""

from __future__ import annotations

import re
from collections.abc import Mapping

from camid.diagnosis.explanation import within_sentence
from camid.diagnosis.report.summary import title_of
from camid.effects.known import declarable_effects


def with_titles(text: str, own: Mapping[str, str] | None = None) -> str:
    """A sentence with the titles of effects in the place of their identifiers, which files use."""
    known = {*declarable_effects(), *(own or {})}

    def titled(match: re.Match[str]) -> str:
        found = match.group()
        if found not in known:
            return found
        title = title_of(found, own)
        return title if match.start() == 0 else within_sentence(title)

    return re.sub(r"(?<![\w./-])[a-z]+(?:-[a-z]+)+(?![\w/-])", titled, text)
