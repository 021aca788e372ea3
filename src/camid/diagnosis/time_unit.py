"""Whether re-estimated coefficients are those of a time that is counted in another unit than seconds."""

from __future__ import annotations

from collections.abc import Sequence
from math import log10

from camid.diagnosis.diagnosis import Coefficient

# Units of a time column in seconds.
UNITS = {"ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
# Decades that a coefficient may be off, which the believed ones are known within, and that it is off at least for a
# unit to be asked about.
KNOWN_WITHIN, FAR_OFF = 0.6, 1.5


def said_of_time_unit(coefficients: Sequence[Coefficient], time_column: str, *, declared: bool) -> list[str]:
    """A sentence where a power of the unit's size for each s explains what nothing else would.

    A coefficient a_k in s⁻ⁿ⁺ᵏ that is estimated with times in ms is smaller by 1000ⁿ⁻ᵏ.

    Parameters
    ----------
    coefficients : sequence of Coefficient
        Of a transfer function, a0 last.
    time_column : str
    declared : bool
        Whether the simulation, or the column's header, says the unit of the times.
    """
    powers = _powers(coefficients)
    if declared or not powers:
        return []
    off = [(power, log10(abs(c.refitted / c.nominal))) for power, c in powers]
    if max(abs(decades) for _, decades in off) < FAR_OFF:
        return []
    for unit, seconds in UNITS.items():
        if all(abs(decades - power * log10(seconds)) < KNOWN_WITHIN for power, decades in off):
            return [
                f"the coefficients are those of times in {unit}: if the column '{time_column}' counts {unit}, say "
                f"time: {{column: {time_column}, unit: {unit}}}"
            ]
    return []


def _powers(coefficients: Sequence[Coefficient]) -> list[tuple[int, Coefficient]]:
    """Coefficients of a denominator that are known to be there, with their powers of 1/s."""
    found = [(int(c.name[1:]), c) for c in coefficients if c.name.startswith("a") and c.name[1:].isdigit()]
    order = max((index for index, _ in found), default=0) + 1
    return [(order - index, c) for index, c in found if c.nominal != 0.0 and c.refitted != 0.0]
