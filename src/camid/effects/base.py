"""The form of every effect: one class with its equation, parameters, first guesses and contribution to the chain.

An effect is an instance with values (:class:`EffectValues`). What it does is said by the hooks below, what a diagnosis
asks of it by those of :class:`SearchHooks`; a class overrides those it needs and is then known everywhere: catalogue,
simulation files, engine, diagnosis, report and documentation. docs/adding_an_effect.md shows how one is added.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.compiled_part import Compiled
from camid.effects.effect_values import EffectValues
from camid.effects.known import is_of_the_package, make_known
from camid.effects.search_hooks import SearchHooks
from camid.effects.separating_experiment import SeparatingExperiment
from camid.effects.situation import Situation

if TYPE_CHECKING:
    from camid.chain.motion import Motion

Array = NDArray[np.float64]

PLACES = ("actuator", "plant", "disturbance", "sensor", "noise")


class LimitedState(NamedTuple):
    """A level that runs over an edge; ``share`` of what does reaches the state that it feeds."""

    state: str
    edge: float
    share: float


class Effect(EffectValues, SearchHooks):
    """Base of all effects.

    Attributes
    ----------
    identifier, place, title, equation, reference : str
        ``equation`` is LaTeX without dollar signs.
    parameters : tuple of Parameter
    strength : str or None
        Parameter to which the effect is proportional while it is small; None where none is.
    trials : str
        How many different effects a search over the shape amounts to: ``shapes`` (as many as candidates), ``frames``
        (anywhere in the recording) or ``frequencies``.
    listed : bool
        Whether it belongs to the catalogue, whose effects a diagnosis looks for; a simulation may declare others, too.
    sum_of : tuple of str
        Identifiers of effects that together are exactly this one, so that no input and output tells them apart.
    acts_on_reading : bool
        Of an effect at the sensor, whether it acts on what is read, offset included, and not on the position.
    size_is_shape : bool
        Whether another size of it is another pattern, so that a guess is begun in the size in which it was screened.
    jumps_by : str, optional
        Parameter by which the output jumps, so that no derivative says how well it is determined.
    is_constant : bool
        Whether it adds a constant to a signal: what declares it leaves no such constant to be estimated.
    linear_dynamics : bool
        Whether input and output stay linear: other linear dynamics that it imitates, it imitates with every input.
    keeps_hold : bool
        Whether a held input is still held after the effect.
    noise_like : bool
        Whether the effect changes the noise and not the expected output, so that no simulation shows it.
    transforms_by_compiled_code : bool
        Whether :meth:`transform` calls compiled code, which is then compiled with the rest (camid.compile_all).
    uses_velocity : bool
        Whether the force depends on the velocity, which a plant with one pole more than zeros lets it change at once.
    jumps : bool
        Whether the force jumps where its switch changes sign: a step that holds the jump then sees two forces, however
        short it is, and :meth:`frequency` alone says how short steps have to be.
    separated_by : tuple of SeparatingExperiment
        Experiments that separate the effect from the others that name them, too.
    corrects_declaration : bool
        Whether a simulation declares it by other keys (hold, exposure, latency), which the improved one then corrects.
    box : str
        Box of the chain that the report marks: the place, if nothing else is said.
    drawn_against : str
        What the report draws it against (camid.diagnosis.report.effect_pictures); empty: what its place suggests.
    spoils_rows : bool
        Of a noise-like effect, whether its rows say nothing of the motion, whatever the model.
    shows_in_values : bool
        Of a noise-like effect, whether the recorded values alone show it, so that structure left in the residual cannot
        imitate it.
    makes_variance_uneven : bool
        Of a noise-like effect, whether it makes the variance of the noise change with the position.
    judged_by_even_spread : bool
        Of a noise-like effect, whether noise of a variance that changes (see :meth:`added_variance`) imitates it.
    colours_noise : bool
        Whether it describes a residual that is not white; see :meth:`of_autoregression`.
    of_one_recording : bool
        Whether it depends on the time, so that another recording of the same rig says nothing of it.
    prior_odds : float
        Of it beside effects that the data often show as well, where rigs have it more rarely.
    bends_coefficients : bool
        Of an effect without parameters, whether coefficients that are re-estimated without it mean nothing.
    finer_laws : tuple of type of Effect
        Laws of the same name with more parameters: subclasses without an identifier of their own.
    """

    place: ClassVar[str]
    title: ClassVar[str]
    equation: ClassVar[str]
    reference: ClassVar[str]
    trials: ClassVar[str] = "shapes"
    listed: ClassVar[bool] = True
    sum_of: ClassVar[tuple[str, ...]] = ()
    linear_dynamics: ClassVar[bool] = False
    keeps_hold: ClassVar[bool] = False
    acts_on_reading: ClassVar[bool] = False
    size_is_shape: ClassVar[bool] = False
    jumps_by: ClassVar[str | None] = None
    is_constant: ClassVar[bool] = False
    noise_like: ClassVar[bool] = False
    transforms_by_compiled_code: ClassVar[bool] = False
    uses_velocity: bool = False
    jumps: bool = False
    separated_by: ClassVar[tuple[SeparatingExperiment, ...]] = ()
    corrects_declaration: ClassVar[bool] = False
    box: ClassVar[str]
    drawn_against: ClassVar[str] = ""
    spoils_rows: ClassVar[bool] = False
    shows_in_values: ClassVar[bool] = False
    makes_variance_uneven: ClassVar[bool] = False
    judged_by_even_spread: ClassVar[bool] = False
    colours_noise: ClassVar[bool] = False
    of_one_recording: ClassVar[bool] = False
    prior_odds: ClassVar[float] = 1.0
    bends_coefficients: ClassVar[bool] = False
    finer_laws: ClassVar[tuple[type[Effect], ...]] = ()
    # Compiled parts; see :class:`Compiled` for their arguments.
    force: ClassVar[Compiled | None] = None
    """Force against the motion, in units of u."""
    friction_level: ClassVar[Compiled | None] = None
    """Dry friction at a speed ≥ 0, in units of u; at speed zero what holds a body that sticks."""
    memory_after: ClassVar[Compiled | None] = None
    """Inner state that the force depends on, zero at rest: what becomes of ``memory`` over a displacement, which
    replaces ``position``, at a mean velocity."""
    largest_memory: ClassVar[float | None] = None
    """Size that the inner state may have in motion that goes on before the record; None where it is zero at first."""
    switch: ClassVar[Compiled | None] = None
    """Function whose change of sign marks a kink of the force."""
    actuated: ClassVar[Compiled | None] = None
    """What the actuator makes of a command that a controller puts out, which no :meth:`transform` can know: ``time`` is
    the length of the step and ``memory`` what it made of the last one."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        cls.finer_laws = ()
        if "identifier" in vars(cls):
            place = getattr(cls, "place", None)
            if place not in PLACES:
                raise ValueError(f"{cls.__name__}: place '{place}' is not one of {', '.join(PLACES)}")
            if "box" not in vars(cls):
                cls.box = cls.place
            # A user's own are known where they are asked for alone: camid.effects.own_effects.
            if is_of_the_package(cls):
                make_known(cls)
        elif "parameters" in vars(cls) and hasattr(cls, "identifier"):
            known = next(base for base in cls.__mro__[1:] if issubclass(base, Effect) and "identifier" in vars(base))
            known.finer_laws = (*known.finer_laws, cls)

    @classmethod
    def with_keys(cls, keys: Iterable[str]) -> type[Effect]:
        """The law of this name that has such parameters: this one, or one of :attr:`finer_laws`."""
        wanted = set(keys)
        return next((law for law in (cls, *cls.finer_laws) if wanted <= {p.name for p in law.parameters}), cls)

    @classmethod
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """First guesses of a finer law beside values that are known of it."""
        yield cls(**values)

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """Laws with more detail, started from this one, that a search tries where this one leaves structure.

        ``situation`` is that of the fitted model which holds this one.
        """
        return tuple(start for law in self.finer_laws for start in law.starts(situation, **self.values))

    @property
    def imitates_linear_dynamics(self) -> bool:
        """Whether it is linear dynamics with numbers, which a fit bends until they do what other linear dynamics do."""
        return self.linear_dynamics and bool(self.numeric())

    @property
    def one_sided(self) -> bool:
        """Whether the effect exists in one direction only: its strength cannot be negative, or it has none."""
        if self.strength is None:
            return True
        return next(p.lower for p in self.parameters if p.name == self.strength) >= 0.0

    # -- what the effect does; a class overrides what it needs -----------------------------------------------------

    def beside(self, others: Sequence[Effect], period: float) -> Effect:
        """The same effect as it acts in a chain, beside all its effects, with a sampling period in s; or itself."""
        return self

    def least_deviations(self, period: float) -> Mapping[str, float]:
        """Standard deviations, with a sampling period in s, below which samples do not tell a parameter."""
        return {}

    def force_values(self, plant: TransferFunction) -> list[float]:
        """What the compiled parts get as ``values``."""
        return list(self.vector)

    def frequency(self, plant: TransferFunction) -> float:
        """Angular frequency in rad/s that the effect adds to those of the plant; the integrator's step follows it."""
        return 0.0

    def breaks(self) -> tuple[float, ...]:
        """Times in seconds at which the force jumps."""
        return ()

    def impulses(self) -> tuple[tuple[float, float], ...]:
        """Times in seconds and sizes (u·s) of impulses at the plant's input."""
        return ()

    def said_of_coefficients(self) -> str | None:
        """What has to be known of the plant's coefficients beside the effect, in a sentence; None where nothing has."""
        return None

    def limited_state(self) -> LimitedState | None:
        """The state of a plant's equations that the effect limits."""
        return None

    def declare(self, acquisition: Acquisition) -> Acquisition:
        """Another declaration of hold, sensor, exposure or latency."""
        return acquisition

    def before_plant(self) -> TransferFunction | None:
        """Linear dynamics between hold and plant."""
        return None

    def beside_plant(self) -> TransferFunction | None:
        """Linear dynamics that the plant's input drives, too, and whose output adds to the plant's."""
        return None

    def after_plant(self) -> TransferFunction | None:
        """Linear dynamics between plant and sensor."""
        return None

    def transform(self, start: Array, end: Array, step: float) -> tuple[Array, Array]:
        """Input after the effect on a grid: value at the start and at the end of each step of ``step`` seconds."""
        return start, end

    def windows(self, motion: Motion, start: Array, end: Array) -> tuple[Array, Array]:
        """Start and end of the exposures in seconds, shape (N,), where the effect shifts them."""
        return start, end

    def ahead(self, time: Array) -> float:
        """Seconds after the last of the recorded times, shape (N,), up to which the readings need the motion."""
        return 0.0

    def carry(self, motion: Motion) -> Motion:
        """The motion of what the sensor sees, where that is not the plant's."""
        return motion

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """What an exposure yields, shape (N,), where it is not the mean; None where it is."""
        return None

    def observe(self, output: Array, time: Array) -> Array:
        """What becomes of the sensor's samples, shape (N,), at the recorded times."""
        return output

    def picked_up(self, signal: Array) -> Array | None:
        """What the recorded input, shape (N,), adds to the samples of its rows; None where it adds nothing."""
        return None
