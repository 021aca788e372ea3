"""The form of every effect: one class with its equation, parameters, first guesses and contribution to the chain.

An effect is an instance with values. What it does is said by the hooks below; a class overrides those it needs and is
then known everywhere: catalogue, simulation files, engine, diagnosis, report and documentation.
docs/adding_an_effect.md shows how one is added.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.compiled_part import Compiled
from camid.effects.extent import Extent
from camid.effects.known import is_of_the_package, make_known
from camid.effects.parameter import Parameter, checked
from camid.effects.recognition import Recognition
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


class Effect:
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
    bends_coefficients : bool
        Of an effect without parameters, whether coefficients that are re-estimated without it mean nothing.
    finer_laws : tuple of type of Effect
        Laws of the same name with more parameters: subclasses without an identifier of their own.

    Raises
    ------
    ValueError
        If a parameter is missing, unknown, not finite or out of its bounds.
    """

    identifier: ClassVar[str]
    place: ClassVar[str]
    title: ClassVar[str]
    equation: ClassVar[str]
    reference: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    strength: ClassVar[str | None] = None
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
    bends_coefficients: ClassVar[bool] = False
    finer_laws: ClassVar[tuple[type[Effect], ...]] = ()
    # Compiled parts; see :class:`Compiled` for their arguments.
    force: ClassVar[Compiled | None] = None
    """Force against the motion, in units of u."""
    friction_level: ClassVar[Compiled | None] = None
    """Dry friction at a speed ≥ 0, in units of u; at speed zero what holds a body that sticks."""
    memory_after: ClassVar[Compiled | None] = None
    """Inner state, zero at first, that the force depends on: what becomes of ``memory`` over a displacement, which
    replaces ``position``, at a mean velocity."""
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

    def __init__(self, **values: Any) -> None:
        known = [p.name for p in self.parameters]
        for name in values:
            if name not in known:
                raise ValueError(f"{self.identifier} has no parameter '{name}' (known: {', '.join(known) or 'none'})")
        self.values: dict[str, Any] = {}
        self._neutral: tuple[float, ...] | None = None
        self.leads = False
        for parameter in self.parameters:
            if parameter.name not in values and parameter.default is None:
                raise ValueError(f"{self.identifier} needs the parameter '{parameter.name}'")
            value = values.get(parameter.name, parameter.default)
            self.values[parameter.name] = checked(self.identifier, parameter, value)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.values.items())})"

    @classmethod
    def with_keys(cls, keys: Iterable[str]) -> type[Effect]:
        """The law of this name that has such parameters: this one, or one of :attr:`finer_laws`."""
        wanted = set(keys)
        return next((law for law in (cls, *cls.finer_laws) if wanted <= {p.name for p in law.parameters}), cls)

    # -- parameters ------------------------------------------------------------------------------------------------

    @classmethod
    def numeric(cls) -> tuple[Parameter, ...]:
        """Parameters that are numbers, in order."""
        return tuple(p for p in cls.parameters if p.is_number)

    def stated(self) -> dict[str, Any]:
        """Values by name, without names that say nothing: that of a state, of a plant without equations."""
        silent = {p.name for p in self.parameters if p.is_name and self.values[p.name] == p.default}
        return {name: value for name, value in self.values.items() if name not in silent}

    @property
    def vector(self) -> Array:
        """Values of the parameters that are numbers, in order."""
        return np.array([self.values[p.name] for p in self.numeric()], dtype=float)

    def with_vector(self, vector: Array) -> Self:
        """The same effect with other numbers, moved to the nearest allowed value."""
        changed = {p.name: float(min(max(v, p.lower), p.upper)) for p, v in zip(self.numeric(), vector, strict=True)}
        moved = type(self)(**{**self.values, **changed})
        moved._neutral = self._neutral
        moved.leads = self.leads
        return moved

    def bounds(self, acquisition: Acquisition) -> list[tuple[float, float]]:
        """Least and largest value of each number in :attr:`vector` with this acquisition."""
        return [(p.lower, p.upper) for p in self.numeric()]

    def within(self, acquisition: Acquisition) -> Self:
        """The same effect, its numbers moved to the nearest that are allowed with this acquisition."""
        lower, upper = np.array(self.bounds(acquisition)).reshape(-1, 2).T
        return self.with_vector(np.clip(self.vector, lower, upper))

    def is_plausible(self, extent: Extent) -> bool:
        """Whether the values are possible on the positions, and in the seconds, that a recording spans.

        What repeats has to do so there, for instance: less than a period of a sinusoid is a polynomial, which other
        effects name.
        """
        return True

    def measured_from(self, *neutral: float) -> Self:
        """The same effect, given the values of its parameters this recording shows nothing of it."""
        self._neutral = neutral
        return self

    def leading(self, leads: bool = True) -> Self:
        """The same effect, acting on the input before those that stand ahead of it in a model; or where it stands."""
        moved = copy(self)
        moved.leads = leads
        return moved

    @property
    def branch(self) -> tuple[Any, ...]:
        """What no fit changes in a guess: choices, and parameters whose value leaves the recording as it is."""
        words = tuple(v for v in self.values.values() if isinstance(v, str)) + ("leading",) * self.leads
        return words if self._neutral is None else (*words, *(self.vector == np.asarray(self._neutral)).tolist())

    @property
    def idle(self) -> frozenset[str]:
        """Numbers that have the value of which this recording shows nothing."""
        if self._neutral is None:
            return frozenset()
        numbers = zip(self.numeric(), self.vector, self._neutral, strict=True)
        return frozenset(parameter.name for parameter, value, neutral in numbers if value == neutral)

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
        """The same law at values from where a fit may end in a better minimum, tried where structure is left.

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
    def starts(cls, situation: Situation, **values: Any) -> Iterator[Effect]:
        """First guesses of a finer law beside values that are known of it."""
        yield cls(**values)

    def finer(self, situation: Situation) -> tuple[Effect, ...]:
        """Laws with more detail, started from this one, that a search tries where this one leaves structure.

        ``situation`` is that of the fitted model which holds this one.
        """
        return tuple(start for law in self.finer_laws for start in law.starts(situation, **self.values))

    def scaled(self, factor: float) -> Self:
        """The same effect, changing the output by about ``factor`` ≥ 0 times as much; the same where it has no size."""
        if self.strength is not None:
            vector = self.vector
            vector[[p.name for p in self.numeric()].index(self.strength)] *= factor
            return self.with_vector(vector)
        if self._neutral is not None:
            neutral = np.asarray(self._neutral)
            return self.with_vector(neutral + max(factor, 0.0) * (self.vector - neutral))
        return self

    # -- what the effect does; a class overrides what it needs -----------------------------------------------------

    def beside(self, others: Sequence[Effect], period: float) -> Effect:
        """The same effect as it acts in a chain, beside all its effects, with a sampling period in s; or itself."""
        return self

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

    def carry(self, motion: Motion) -> Motion:
        """The motion of what the sensor sees, where that is not the plant's."""
        return motion

    def measure(self, motion: Motion, start: Array, end: Array) -> Array | None:
        """What an exposure yields, shape (N,), where it is not the mean; None where it is."""
        return None

    def observe(self, output: Array, time: Array) -> Array:
        """What becomes of the sensor's samples, shape (N,), at the recorded times."""
        return output

    # -- what the diagnosis asks -----------------------------------------------------------------------------------

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
