"""What set in at a moment of which a recording has no row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camid.diagnosis.explanation import within_sentence
from camid.diagnosis.finding import Finding
from camid.effects import known_effects
from camid.number_text import SPACE, plain, span
from camid.recording.recording import Recording


def moments_in_gaps(found: Sequence[Finding], recordings: Sequence[Recording]) -> list[str]:
    """A sentence for each effect of one recording that sets in where rows of it are missing.

    Parameters
    ----------
    found : sequence of Finding
        In SI units.
    recordings : sequence of Recording
    """
    sentences = []
    for finding in found:
        moment = finding.parameters.get("time")
        if moment is None or not known_effects()[finding.identifier].of_one_recording:
            continue
        for recording in recordings:
            gap = _gap_around(recording, float(moment.value))
            if gap is not None:
                what, when = within_sentence(finding.title), plain(float(moment.value), 4, "s").replace(SPACE, " ")
                sentences.append(
                    f"{recording.source}: the time of {what}, {when}, lies in a gap of the recording "
                    f"({span(gap, 's')}): what the rig and its input did there was not recorded, and may look like it"
                )
    return sentences


def _gap_around(recording: Recording, moment: float) -> tuple[float, float] | None:
    """Times of the recorded rows before and after a moment, where there is none in a row between them."""
    known = np.flatnonzero(~recording.missing)
    after = int(np.searchsorted(recording.time[known], moment))
    if not 0 < after < len(known) or known[after] - known[after - 1] < 2:
        return None
    return float(recording.time[known[after - 1]]), float(recording.time[known[after]])
