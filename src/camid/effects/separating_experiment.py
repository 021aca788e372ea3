"""Experiments that tell effects apart which one recording could not; an effect names those that separate it."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum


class SeparatingExperiment(Enum):
    """An experiment that separates the effects which name it, and the advice to the reader.

    Of several that separate two effects the first one here is advised.
    """

    FASTER_CAMERA = (
        "Input and output of one camera cannot tell these apart at first order. Flash a light with the command to "
        "measure the latency, shorten the exposure at the same frame rate, or record at twice the frame rate with "
        "an input that has energy up to half of it."
    )
    REVERSED_INPUT = (
        "Record the rig at rest with zero input, then repeat the recording with the input's sign reversed and "
        "with half of its amplitude: an offset stays, an asymmetry scales with the input."
    )
    MANY_LEVELS = (
        "Use an input with at least three levels that reach from small to large values, and slow ramps up and down."
    )
    FREE_DECAY = (
        "Record a free decay from a large amplitude, and slow reversals of small amplitude: dry friction stops "
        "the motion linearly and holds it, hysteresis closes loops, drag fades with the amplitude."
    )
    HELD_POSITIONS = (
        "Repeat the recording at half and at twice the amplitude, and hold the rig still at several positions: "
        "the sensor's curve shows at rest, a spring's law in the force that holds it, a stop beyond its "
        "position only."
    )
    SCALE_IN_THE_IMAGE = "Move the marker slowly by hand through the whole image beside a scale."
    REPEATED_INPUT = "Repeat exactly the same input several times in one long recording, and record once without input."
    NO_INPUT = (
        "Record once without input and watch what happens after the event: a blow rings down, a wrong frame does not."
    )

    def advised(self, *, driven: bool, filmed: bool = True) -> str | None:
        """What a reader is told, also of a recording without an input or of no camera; None where it takes an input."""
        if not driven and self in NEEDS_INPUT:
            return None
        text = self.value if driven else UNDRIVEN.get(self, self.value)
        return text if filmed else (UNFILMED if driven else UNFILMED_UNDRIVEN).get(self, text)


OTHERWISE = "Repeat the recording at half and at twice the amplitude, and once without input."
# Of a recording without an input, which is a free decay already and has no command to repeat or to reverse.
UNDRIVEN = {
    SeparatingExperiment.FREE_DECAY: (
        "Record further decays, from half and from twice this amplitude and down to rest: dry friction stops the "
        "motion linearly and holds it, hysteresis closes loops, drag fades with the amplitude."
    ),
    SeparatingExperiment.FASTER_CAMERA: (
        "Shorten the exposure at the same frame rate, or record at twice the frame rate: what the shutter does changes "
        "with them, what the plant does stays."
    ),
    SeparatingExperiment.REPEATED_INPUT: (
        "Record several decays from the same start, and once the rig at rest: what drives it from outside shows there, "
        "too."
    ),
    SeparatingExperiment.NO_INPUT: (
        "Record once more and go on after the event: a blow rings down, a wrong frame does not; and record the rig at "
        "rest."
    ),
}
# Of a sensor that is no camera.
UNFILMED = {
    SeparatingExperiment.FASTER_CAMERA: (
        "Input and output at one rate cannot tell these apart at first order. Log the command and the reading by one "
        "clock to measure the latency, or record at twice the rate with an input that has energy up to half of it."
    ),
    SeparatingExperiment.SCALE_IN_THE_IMAGE: "Move it slowly by hand through the sensor's whole range beside a scale.",
}
UNFILMED_UNDRIVEN = UNFILMED | {
    SeparatingExperiment.FASTER_CAMERA: (
        "Record at twice the rate: what happens between two samples changes with it, what the plant does stays."
    ),
}
NEEDS_INPUT = {SeparatingExperiment.REVERSED_INPUT, SeparatingExperiment.MANY_LEVELS}
OTHERWISE_UNDRIVEN = "Record further decays, from half and from twice this amplitude, and once the rig at rest."


def otherwise(*, driven: bool) -> str:
    """What a reader is told where nothing better is known."""
    return OTHERWISE if driven else OTHERWISE_UNDRIVEN


def advice(
    likeliest: Iterable[SeparatingExperiment],
    others: Iterable[Iterable[SeparatingExperiment]],
    *,
    driven: bool = True,
    filmed: bool = True,
) -> str | None:
    """What would separate the likeliest effect from others that a recording does not rule out; None without others.

    Parameters
    ----------
    likeliest : iterable of SeparatingExperiment
        Those that separate the likeliest effect.
    others : iterable of iterable of SeparatingExperiment
        The same of each alternative.
    driven : bool
        Whether an input drove the recording.
    filmed : bool
        Whether the sensor is a camera.
    """
    shared = [set(likeliest) & set(experiments) for experiments in others]
    if not shared:
        return None
    useful = set().union(*shared)
    told = (
        experiment.advised(driven=driven, filmed=filmed) for experiment in SeparatingExperiment if experiment in useful
    )
    return next(filter(None, told), otherwise(driven=driven))
