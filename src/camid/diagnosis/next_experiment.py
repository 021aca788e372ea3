"""What to record next where something is left out that has no name."""

from __future__ import annotations

from camid.diagnosis.diagnosis import Diagnosis
from camid.effects.separating_experiment import SeparatingExperiment, otherwise

# What separates the effects of a place, where none of them is likelier than the others.
OF_PLACE = {
    "actuator": (SeparatingExperiment.MANY_LEVELS, SeparatingExperiment.REVERSED_INPUT),
    "plant": (SeparatingExperiment.FREE_DECAY, SeparatingExperiment.HELD_POSITIONS),
    "disturbance": (SeparatingExperiment.REPEATED_INPUT,),
    "sensor": (SeparatingExperiment.HELD_POSITIONS, SeparatingExperiment.SCALE_IN_THE_IMAGE),
    "noise": (SeparatingExperiment.NO_INPUT,),
}


def next_experiments(diagnosis: Diagnosis) -> list[str]:
    """Advice, a sentence or two each, the most telling first; none where effects are named or nothing is missing."""
    if diagnosis.findings or diagnosis.verdict == "adequate":
        return []
    driven, filmed = diagnosis.improved.input_column is not None, diagnosis.improved.sensor == "camera"
    told = [
        experiment.advised(driven=driven, filmed=filmed)
        for experiment in OF_PLACE.get(diagnosis.location.place or "", ())
    ]
    return [*filter(None, told), otherwise(driven=driven)]
