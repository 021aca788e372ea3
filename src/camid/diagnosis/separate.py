"""Which experiment would tell apart what a recording could not."""

from __future__ import annotations

from collections.abc import Sequence

# Groups of effects that one experiment separates, and that experiment; the first group that holds two members counts.
EXPERIMENTS: tuple[tuple[frozenset[str], str], ...] = (
    (
        frozenset({"delay", "actuator-lag", "exposure", "input-hold", "extra-mode", "rate-limit"}),
        "Input and output of one camera cannot tell these apart at first order. Flash a light with the command to "
        "measure the latency, shorten the exposure at the same frame rate, or record at twice the frame rate with "
        "an input that has energy up to half of it.",
    ),
    (
        frozenset({"input-bias", "sensor-offset", "gain-asymmetry", "quadratic-stiffness", "step-disturbance"}),
        "Record the rig at rest with zero input, then repeat the recording with the input's sign reversed and "
        "with half of its amplitude: an offset stays, an asymmetry scales with the input.",
    ),
    (
        frozenset({"dead-zone", "saturation", "backlash"}),
        "Use an input with at least three levels that reach from small to large values, and slow ramps up and down.",
    ),
    (
        frozenset({"coulomb-friction", "stribeck-friction", "hysteresis", "quadratic-drag", "backlash"}),
        "Record a free decay from a large amplitude, and slow reversals of small amplitude: dry friction stops "
        "the motion linearly and holds it, hysteresis closes loops, drag fades with the amplitude.",
    ),
    (
        frozenset(
            {"cubic-stiffness", "pendulum-gravity", "quadratic-stiffness", "end-stop", "lens-distortion", "perspective"}
        ),
        "Repeat the recording at half and at twice the amplitude, and hold the rig still at several positions: "
        "the camera's distortion shows at rest, a spring's law in the force that holds it, a stop beyond its "
        "position only.",
    ),
    (
        frozenset({"clipping", "lens-distortion", "perspective", "saturation", "absolute-value"}),
        "Move the marker slowly by hand through the whole image beside a scale.",
    ),
    (
        frozenset({"parameter-drift", "clock-skew", "sensor-drift", "periodic-disturbance", "step-disturbance"}),
        "Repeat exactly the same input several times in one long recording, and record once without input.",
    ),
    (
        frozenset({"impulse-disturbance", "outliers", "step-disturbance", "dropped-frames"}),
        "Record once without input and watch what happens after the event: a blow rings down, a wrong frame does not.",
    ),
)
OTHERWISE = "Repeat the recording at half and at twice the amplitude, and once without input."


def separating_experiment(identifiers: Sequence[str]) -> str | None:
    """Advice for effects that a recording does not tell apart; None for a single one.

    Parameters
    ----------
    identifiers : sequence of str
        The likeliest first.
    """
    if len(identifiers) < 2:
        return None
    for group, experiment in EXPERIMENTS:
        if identifiers[0] in group and any(i in group for i in identifiers[1:]):
            return experiment
    return OTHERWISE
