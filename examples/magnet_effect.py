"""A magnet beside the way, as an effect for camid diagnose --effects; docs/own_effects.md explains it."""

from math import exp

import numpy as np

from camid.effects import Effect, Parameter, compiled


class Magnet(Effect):
    """A magnet beside the way: it pulls to its place, most at some distance from it, and far away not at all."""

    identifier = "magnet"
    place = "plant"
    title = "Magnet beside the way"
    equation = r"f = F\,z\,e^{-z^2},\quad z = (y - p)/w"
    reference = "a force of short range, for want of a table of the magnet"
    parameters = (
        Parameter("force", "u", "pull F; negative for one that pushes away"),
        Parameter("position", "y", "place p of the magnet"),
        Parameter("width", "y", "range w of its force", lower=1e-300),
    )
    strength = "force"

    @compiled
    def force(time, position, velocity, signal, memory, values):
        z = (position - values[1]) / values[2]
        return values[0] * z * exp(-z * z)

    @classmethod
    def candidates(cls, situation):
        """A weak one at each of many places of the way, narrow and wide."""
        low, high = np.min(situation.position), np.max(situation.position)
        for place in np.linspace(low, high, 21)[1:-1]:
            for share in (0.04, 0.1):
                yield cls(
                    force=0.02 * situation.largest("signal"), position=float(place), width=float(share * (high - low))
                )
