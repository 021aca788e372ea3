"""Which other declaration of hold, sensor, exposure or latency a residual that depends on the input supports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.identification.residual_analysis import (
    ALARM,
    ResidualAnalysis,
)
from camid.number_text import equals_probability, percentage, plain

Array = NDArray[np.float64]

# Residual, as a share of the output's spread, that the refinement of a number leaves.
NEGLIGIBLE = 1e-6
# Declarations whose deviances (-2 log likelihood) differ by less cannot be told apart.
SAME_DEVIANCE = 6.0


@dataclass(frozen=True)
class Alternative:
    """Another declaration, with which the plant was re-estimated.

    Attributes
    ----------
    acquisition : Acquisition
    changed : tuple of str
        What differs from the declaration: ``hold``, ``sensor``, ``exposure``, ``latency``.
    plant : TransferFunction
    nrmse : float
        Root mean square residual over the standard deviation of the recorded output.
    analysis : ResidualAnalysis
    """

    acquisition: Acquisition
    changed: tuple[str, ...]
    plant: TransferFunction
    nrmse: float
    analysis: ResidualAnalysis

    @property
    def passes(self) -> bool:
        """Whether what is left does not depend on the input, or is only what the refinement of a number leaves."""
        negligible = self.analysis.at_rounding or self.nrmse <= NEGLIGIBLE
        return negligible or (self.analysis.independence_p or 0.0) >= ALARM

    def to_mapping(self) -> dict[str, Any]:
        """Part of ``--json``."""
        return {
            "changed": list(self.changed),
            "hold": self.acquisition.hold,
            "sensor": self.acquisition.sensor,
            "exposure": self.acquisition.exposure if self.acquisition.sensor == "camera" else None,
            "latency": self.acquisition.latency,
            "nrmse": self.nrmse,
            "independence_p": self.analysis.independence_p,
            "passes": self.passes,
        }


def described(acquisition: Acquisition, changed: tuple[str, ...], *, article: bool = True) -> str:
    """What an acquisition says about the parts that are named."""
    a, an = ("a ", "an ") if article else ("", "")
    exposure = f"exposure of {plain(1e3 * (acquisition.exposure or 0.0))} ms"
    instant = acquisition.sensor == "instant"
    words = {
        "hold": f"hold {acquisition.hold}",
        "sensor": f"{an}instant sensor" if instant else f"{a}camera with an {exposure}",
        "exposure": f"{an}{exposure}",
        "latency": f"{a}latency of {plain(1e3 * acquisition.latency)} ms",
    }
    return ", ".join(words[part] for part in changed[:-1]) + (" and " if changed[:-1] else "") + words[changed[-1]]


def contradiction_sentence(
    analysis: ResidualAnalysis, nrmse: float, declared: Acquisition, alternatives: list[Alternative]
) -> str:
    """Sentence on a residual that depends on the input, and on what explains it."""
    sentence = f"the residual depends on the input (p {equals_probability(analysis.independence_p or 0.0)})"
    before = percentage(nrmse)
    if not any(a.passes for a in alternatives):
        sentence += ", and no hold, exposure or latency explains it"
        better = [a for a in alternatives if a.nrmse < nrmse]
        if better:
            best = better[0]
            sentence += (
                f" (best: {described(best.acquisition, best.changed)}, from {before} to {percentage(best.nrmse)}, "
                f"p {equals_probability(best.analysis.independence_p or 0.0)})"
            )
        return sentence + ": order too low, nonlinearity, feedback, …"
    named = explanations(alternatives)
    if len(named) == 1:
        (one,) = named
        return (
            f"{sentence}: the declared {described(declared, one.changed, article=False)} "
            f"contradict{'' if len(one.changed) > 1 else 's'} the data; with "
            f"{described(one.acquisition, one.changed)} the residual {_goes(named, nrmse)} from {before} "
            f"to {percentage(one.nrmse)} and passes the test{_probability(one)}"
        )
    parts = ("hold", "sensor", "latency")
    to = ", ".join(
        f"to {percentage(a.nrmse)} with {described(a.acquisition, a.changed)}{_probability(a)}" for a in named
    )
    return (
        f"{sentence}: the declaration ({described(declared, parts)}) contradicts the data; "
        f"the residual {_goes(named, nrmse)} from {before} {to}; this recording does not tell these apart"
    )


def explanations(alternatives: list[Alternative]) -> list[Alternative]:
    """Those that pass the test of independence and that the recording does not tell from the likeliest one."""
    passing = sorted((a for a in alternatives if a.passes), key=lambda a: a.analysis.deviance)
    named = [
        a for a in passing if a is passing[0] or a.analysis.deviance < passing[0].analysis.deviance + SAME_DEVIANCE
    ]
    # A declaration without a fitted number is the stronger claim.
    return sorted(named, key=lambda a: "exposure" in a.changed or "latency" in a.changed)


def _goes(named: list[Alternative], nrmse: float) -> str:
    """What the residual does: one that no longer depends on the input may still be larger."""
    return "falls" if all(one.nrmse < nrmse for one in named) else "goes"


def _probability(alternative: Alternative) -> str:
    p = alternative.analysis.independence_p
    return "" if p is None or p < ALARM else f" (p {equals_probability(p)})"
