"""A concealed recording in the making: rig, camera and input are drawn, and the effects brought to their sizes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.proof.concealed.camera_readings import clean, motion, readings, record
from camid.proof.concealed.cases import CATALOGUE, OUTSIDE, TWO_LEVELS_HIDE, Case
from camid.proof.concealed.detectability import Belief, multiple, strength_for
from camid.proof.concealed.excitations import KINDS, TWO_LEVEL, Excitation, draw_excitation
from camid.proof.concealed.machine_integrator import DivergedError
from camid.proof.concealed.rig import Rig, draw_rig
from camid.proof.concealed.rig_setup import Context, Effect, Setup

Array = NDArray[np.float64]

SMALLEST_MULTIPLE, LARGEST_MULTIPLE = 0.3, 100.0
LOWEST_SNR, HIGHEST_SNR = 15.0, 45.0  # dB
# Shares of the recordings that are measured in images, and of those that the machine enters moving.
IMAGE_SHARES = {"none": 0.08, "single": 0.14}
IMAGE_PLACES = {"actuator", "plant", "disturbance"}
MOVING = 0.12
ALTERNATIVE_LAWS = 0.6  # of the effects that have any
HIDDEN_MULTIPLE = 0.5  # that an invisible effect stays below
# Standard deviation of the output with an effect over that without it: beyond, the machine would be another one.
LEAST_MOTION, MOST_MOTION = 0.35, 3.0
GENTLER = 0.7  # factor of the strengths where twice the input would break the machine
ATTEMPTS = 12


@dataclass(frozen=True)
class Built:
    """An effect with its strength, and its size alone: in detectable sizes and in units of the output squared."""

    effect: Effect
    strength: float
    sum_of_squares: float | None


@dataclass
class DrawnRecording:
    """What :func:`draw_recording` draws.

    Attributes
    ----------
    case : Case
    setup : Setup
        Without effects.
    belief : Belief
    excitation : Excitation
    command : ndarray
        V; what is applied before the first frame included.
    baseline : ndarray, shape (N,)
        What the camera sees without effects.
    images : bool
        Whether the readings are taken in images.
    snr_db : float
    seed : int
        Of what is random in the sizing of effects.
    effects : list of Built
    """

    case: Case
    setup: Setup
    belief: Belief
    excitation: Excitation
    command: Array
    baseline: Array
    images: bool
    snr_db: float
    seed: int
    effects: list[Built] = field(default_factory=list)

    def recorded(self, command: Array) -> Array:
        """The samples of a command that are recorded."""
        return command[self.setup.first : self.setup.first + self.setup.frames]

    def setup_with(self, built: list[Built]) -> Setup:
        """The rig with effects."""
        setup = self.setup.copy()
        for item in built:
            item.effect.apply(setup, item.strength)
        return setup

    def output(self, setup: Setup, command: Array) -> Array:
        """What the camera sees, without noise."""
        return clean(setup, readings(setup, motion(setup, command)))

    def noise_std(self, output: Array) -> float:
        """Of the additive noise for a true output."""
        return float(np.std(output)) * 10.0 ** (-self.snr_db / 20.0)

    def left_over(self, effect: Effect, strength: float) -> tuple[float, Array]:
        """Sum of squares by which one effect alone stands out, and the output with it."""
        setup = self.setup_with([Built(effect, strength, None)])
        if effect.noise_like:
            std, trajectory = self.noise_std(self.baseline), motion(setup, self.command)
            with_it, without = (
                record(s, trajectory, std, np.random.default_rng(self.seed), np.random.default_rng(self.seed + 1))
                for s in (setup, self.setup)
            )
            return float(np.sum((with_it - without) ** 2)), self.baseline
        output = self.output(setup, self.command)
        if not effect.fixed and not LEAST_MOTION < np.std(output) / np.std(self.baseline) < MOST_MOTION:
            raise DivergedError("the effect is stronger than the machine")
        return self.belief.left_over(self.recorded(self.command), output), output

    def size(self, effect: Effect, strength: float) -> float:
        """The same in detectable sizes."""
        squares, output = self.left_over(effect, strength)
        return multiple(squares, self.noise_std(output))

    def context(self) -> Context:
        """What an effect may know."""
        setup, acquisition = self.setup, self.belief.acquisition
        return Context(
            setup.rig, setup.period, setup.frames, self.command, self.baseline, setup.exposure, acquisition.latency
        )


def draw_recording(case: Case, draws: np.random.Generator) -> DrawnRecording:
    """Draw everything but the effects.

    Parameters
    ----------
    case : Case
    draws : numpy.random.Generator
    """
    families = [CATALOGUE.get(name) or OUTSIDE[name] for name in case.effects]
    images = draws.random() < IMAGE_SHARES.get(case.kind, 0.0) and all(f.place in IMAGE_PLACES for f in families)
    moving = bool(draws.random() < MOVING)
    size = 10.0 ** draws.uniform(-2.0, 2.0)
    # Faults of a fraction of a period show where the motion is fast beside the frames.
    coarse = bool({"input-hold", "speed-weighted-centroid"} & set(case.effects))
    storage = any(f.storage for f in families)
    rig, period = _draw_rig(draws, all(f.any_order for f in families), coarse, size, storage)
    frames = int(draws.integers(300, 501)) if images else int(np.clip(draws.normal(2000.0, 300.0), 1000, 2500))
    choice = draws.random()
    needs_exposure = {"exposure", "speed-weighted-centroid", "dropped-frames"} & set(case.effects)
    camera = bool(images or needs_exposure or (choice < 0.8 and not any(f.instant for f in families)))
    exposure = (1.0 if choice < 0.5 else float(draws.uniform(0.3, 0.9))) * period if camera else 0.0
    latency = 0.0 if draws.random() < 0.75 else float(draws.uniform(0.1, 1.5)) * period

    setup = Setup(rig, period, frames, exposure, latency, moving, rig.parameters())
    hidden = case.kind == "invisible" and case.effects[0] in TWO_LEVELS_HIDE
    kinds = (TWO_LEVEL,) if hidden else tuple(k for k in KINDS if all(k in f.excitations for f in families))
    excitation = draw_excitation(draws, kinds, size, rig.rate, period, hidden)
    command = excitation.draw(draws, setup.input_length)
    acquisition = Acquisition(period, "zoh", "camera" if camera else "instant", exposure or None, latency)
    snr = float(draws.uniform(LOWEST_SNR, HIGHEST_SNR)) if case.snr_db is None else case.snr_db
    return DrawnRecording(
        case,
        setup,
        Belief(rig.transfer_function(), acquisition, moving),
        excitation,
        command,
        readings(setup, motion(setup, command)),
        images,
        snr,
        int(draws.integers(2**31)),
    )


def _draw_rig(
    draws: np.random.Generator, any_order: bool, coarse: bool, input_size: float, storage: bool
) -> tuple[Rig, float]:
    """A rig and the camera's period in s."""
    order = int(draws.choice([1, 2, 3, 4], p=[0.1, 0.7, 0.1, 0.1])) if any_order else 2
    order = 1 if storage else order
    rig = draw_rig(draws, order, 10.0 ** draws.uniform(-3.0, 3.0), input_size)
    highest = 2.5 if draws.random() < 0.08 else 1.5
    angle = float(np.exp(draws.uniform(np.log(0.5 if coarse else 0.05), np.log(highest))))
    # The fastest declared mode stays below half the sampling rate, or no recording would show it.
    return rig, min(angle / rig.rate, 2.5 / max(rig.series_frequency, rig.rate))


def add_effect(drawn: DrawnRecording, name: str, draws: np.random.Generator) -> None:
    """Draw one effect's law and size, and find the strength that gives it that size.

    Parameters
    ----------
    drawn : DrawnRecording
        Gets the effect, and another signal-to-noise ratio where the effect has no strength to choose.
    name : str
        Identity of the effect.
    draws : numpy.random.Generator
    """
    family = CATALOGUE.get(name) or OUTSIDE[name]
    alternative = family.alternatives and draws.random() < ALTERNATIVE_LAWS
    effect = family.law(draws, drawn.context(), bool(alternative))
    wanted = float(np.exp(draws.uniform(np.log(SMALLEST_MULTIPLE), np.log(LARGEST_MULTIPLE))))
    if drawn.case.kind == "invisible":
        strength = _hidden_strength(drawn, effect, draws)
    elif effect.fixed:
        strength = 1.0
        if effect.noise_like:
            drawn.effects.append(Built(effect, strength, None))
            return
        if len(drawn.case.effects) == 1:
            squares, output = drawn.left_over(effect, strength)
            ratio = wanted / multiple(squares, float(np.std(output)))
            drawn.snr_db = float(np.clip(20.0 * np.log10(ratio), LOWEST_SNR, HIGHEST_SNR))
    else:
        strength = strength_for(wanted, lambda g: drawn.size(effect, g), effect.start, effect.high)
    drawn.effects.append(Built(effect, strength, drawn.left_over(effect, strength)[0]))


def _hidden_strength(drawn: DrawnRecording, effect: Effect, draws: np.random.Generator) -> float:
    """A strength that the recording does not show: of a threshold beyond reach, or of a curve met at two points."""
    beyond = effect.identity not in TWO_LEVELS_HIDE
    strength = float(-draws.uniform(0.1, 0.5) if beyond else draws.uniform(0.1, 0.4))
    for _ in range(ATTEMPTS):
        if drawn.size(effect, strength) < HIDDEN_MULTIPLE:
            break
        # Play shows where it is first taken up, and a stop where only a part of the motion was looked at.
        strength = 1.5 * strength if beyond else 0.5 * strength
    return strength


def make_gentle(drawn: DrawnRecording, commands: list[Array]) -> None:
    """Reduce the strengths until the machine survives all commands, those of twice the amplitude too.

    A softening spring holds only a limited load.
    """
    for _ in range(ATTEMPTS):
        try:
            for command in (drawn.command, *commands):
                drawn.output(drawn.setup_with(drawn.effects), command)
            return
        except DivergedError:
            for i, item in enumerate(drawn.effects):
                strength = GENTLER * item.strength
                drawn.effects[i] = Built(item.effect, strength, drawn.left_over(item.effect, strength)[0])
    raise DivergedError(f"case {drawn.case.index} of seed {drawn.case.seed} cannot be made")
