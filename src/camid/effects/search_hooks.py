"""What a diagnosis asks of an effect: first guesses, what it is related to, and what the noise shows of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from camid.chain.plant import TransferFunction
from camid.effects.extent import Extent
from camid.effects.recognition import Recognition
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.effects.base import Effect

Array = NDArray[np.float64]


class SearchHooks:
    """Hooks that lead a search; an effect overrides those that its guesses need."""

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the values are possible on the positions, and in the seconds, that a recording spans.

        What repeats has to do so there, for instance: less than a period of a sinusoid is a polynomial, which other
        effects name.
        """
        return True

    def simplified(self) -> Effect | None:
        """A simpler effect of about the same size that is a special case of this one; None if there is none."""
        return None

    def relatives(self, situation: Situation) -> tuple[Effect, ...]:
        """Other effects that do nearly the same, in the shape in which they do.

        A search that has fitted this one starts them from there, too: their own first guesses may lead elsewhere.
        ``situation`` is that of the fitted model which holds this one.
        """
        return ()

    def restarts(self, situation: Situation) -> tuple[Effect, ...]:
        """The same law at values from where a fit may end in a better minimum.

        ``situation`` is that of the fitted model which holds this one.
        """
        return ()

    @classmethod
    def with_plant(
        cls, situation: Situation, constants: Mapping[str, float]
    ) -> tuple[Effect, TransferFunction, dict[str, float]] | None:
        """A first guess with the plant and its constants beside which it holds; None where those estimated are near.

        A plant that was estimated without the effect may be so far from the one with it that no fit finds the way, in
        a valley of numbers that make up for each other. ``constants`` are those that are estimated beside its
        coefficients, and positions of the situation count from the zero that was.
        """
        return None

    @classmethod
    def candidates(cls, situation: Situation) -> Iterator[Effect]:
        """First guesses from the data: one for each value of the shape, of a strength that is small but visible."""
        raise NotImplementedError(f"{cls.__name__} guesses nothing")

    @classmethod
    def recognise(cls, situation: Situation) -> Recognition | None:
        """For noise-like effects: whether residual and recorded values show it."""
        raise NotImplementedError(f"{cls.__name__} changes the expected output")

    def added_variance(self, situation: Situation) -> Array | None:
        """For noise-like effects: variance that it adds to the noise of each row, shape (N,); None where it adds none.

        Only what changes from row to row is meant.
        """
        return None

    def bend_of_mean(self, situation: Situation) -> Array | None:
        """For noise-like effects: what it adds to the mean of each reading, shape (N,); None where it adds nothing."""
        return None

    def is_refuted(self, situation: Situation) -> bool:
        """For noise-like effects: whether another recording of the rig, with its residual, speaks against it."""
        return False

    @classmethod
    def of_autoregression(cls, coefficients: Array) -> Effect:
        """For an effect that colours the noise: with the autoregression α_1 … α_p of the residual, shape (p,)."""
        raise NotImplementedError(f"{cls.__name__} does not colour the noise")

    @classmethod
    def limit_of_recognition(cls, situation: Situation) -> str:
        """For noise-like effects: what size of it this recording would have shown, in words."""
        return "it shows in the noise only, and the noise does not show it"

    @classmethod
    def invisible(cls, situation: Situation) -> str | None:
        """Why this recording cannot show the effect, whatever its size; None if it can."""
        return None

    @classmethod
    def same_as(cls, effect: Effect, situation: Situation) -> Effect | None:
        """The effect of this kind that is exactly another one in this recording, and not in others; None if none is."""
        return None
