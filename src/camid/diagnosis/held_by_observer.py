"""A diagnosis with a simulation that an observer pulls, where none follows the recording by itself.

A plant that only a controller holds, and one that is not declared, leaves any recording for the least error where its
motion is unstable, as between two poles of a motor. With an observer the simulation stays near the recording whatever
it leaves out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from camid.chain.observer import Observer, acceleration_of
from camid.diagnosis.diagnosis import Diagnosis
from camid.diagnosis.setting import Setting
from camid.diagnosis.watch import Watch
from camid.effects import known_effects
from camid.engine.work import Work
from camid.fitting.plant_with_effects import Model
from camid.fitting.plants.observed import ObservedPlant
from camid.fitting.problem import Problem
from camid.fitting.remembered_motions import RememberedMotions
from camid.simulation.model import Simulation

# Error of the best simulation, as a share of the output's spread, above which it does not follow the recording.
ASTRAY = 0.05
# The same above which it does not where it is so many times the noise, too.
NEARLY_ASTRAY, FAR_FROM_NOISE = 0.005, 10.0
# The same of a pulled one, as a share of that without effects, up to which it tells what they are, and so much that
# nothing else is looked for.
TELLS, TELLS_ALL = 0.25, 0.05
# The same in noise floors, up to which it is little but noise.
NOISE = 1.5
# Share of what the plant leaves that is pulled without its input, up to which an explanation holds.
TOLD_OF_UNDRIVEN = 0.5
# Rate of the pull in radians per frame, and at most in the time by which frames are late: with a faster one the noise
# counts for more, and a slower one holds less.
USUAL_RATE, MOST_LATE = 0.1, 0.3


def with_observer(believed: Simulation, problem: Problem, nominal: Model) -> tuple[Simulation, Problem, Model] | None:
    """Simulation, problem and nominal model with an observer; None where there is none for such a plant or recording.

    Parameters
    ----------
    believed : Simulation
    problem : Problem
    nominal : Model
        As the simulation says, with the effects that it declares.
    """
    held = believed.plant.denominator[-1] != 0.0  # by itself: what falls is refused without an observer
    logged = any(e.input_log is not None for e in problem.experiments)
    acceleration, acquisition = acceleration_of(believed.plant), problem.acquisition
    if acceleration is None or held or logged or not believed.may_be_observed:
        return None
    late = acquisition.latency + 0.5 * acquisition.window()[2]
    rate = USUAL_RATE / acquisition.period
    observer = Observer(min(rate, MOST_LATE / late) if late > 0.0 else rate, acceleration)
    if not observer.holds(believed.plant):
        return None
    believed = replace(believed, observer=observer)
    kind = ObservedPlant.of(problem.kind, believed, observer).with_unknown(problem.experiments)
    experiments = kind.compared(problem.experiments)
    pulled = replace(problem, kind=kind, experiments=experiments, work=Work(), motions=RememberedMotions())
    return believed, pulled, Model(nominal.coefficients, nominal.effects, constants=kind.constants())


def is_astray(diagnosis: Diagnosis) -> bool:
    """Whether the best simulation of a diagnosis does not follow the recording: it errs, and by more than noise."""
    fits = diagnosis.fit
    coloured = any(known_effects()[f.identifier].colours_noise for f in diagnosis.findings)
    far = fits.improved > ASTRAY or fits.improved > max(NEARLY_ASTRAY, FAR_FROM_NOISE * fits.noise_floor)
    return far and (diagnosis.structured or coloured)


@dataclass(frozen=True)
class Pulled:
    """A diagnosis with a simulation that an observer pulls.

    Attributes
    ----------
    diagnosis : Diagnosis
    model : Model
        Its names and the plant beside them.
    undriven : float
        Normalised error, on the rows that judge, of the plant as given that is pulled alone, without its input: what
        leaves hardly less says nothing, as a law that takes the input away does.
    watch : Watch
        What it left out.
    """

    diagnosis: Diagnosis
    model: Model
    undriven: float
    watch: Watch

    def taken(self, watch: Watch) -> Diagnosis:
        """The diagnosis, with what it left out in the place of what another one did, for lack of time."""
        watch.set(self.watch.state())
        return self.diagnosis

    @property
    def tells_all(self) -> bool:
        """Whether what is found leaves nothing but noise, or next to nothing.

        Where nothing is found the pull may hide what is missing: by themselves the simulations run away with it.
        """
        fits = self.diagnosis.fit
        told = self.diagnosis.verdict == "explained" and fits.improved < TOLD_OF_UNDRIVEN * self.undriven
        is_noise = fits.improved < NOISE * fits.noise_floor
        return told or (is_noise and fits.improved < TELLS_ALL * min(fits.refitted, self.undriven))

    @property
    def tells_more(self) -> bool:
        """Whether what is found says what is missing, where nothing follows without an observer.

        Noise counts on neither side: in the next frames of a pulled simulation there is little but noise.
        """
        fits = self.diagnosis.fit
        noise = min(fits.noise_floor, fits.improved) ** 2
        left, before = fits.improved**2 - noise, min(fits.refitted, self.undriven) ** 2 - noise
        return self.tells_all or left < TELLS**2 * before


def undriven_error(setting: Setting) -> float:
    """Normalised error of the plant as given on the rows that judge, pulled alone."""
    problem = setting.problem
    still = replace(problem, experiments=[replace(e, signal=np.zeros_like(e.signal)) for e in problem.experiments])
    left = still.errors(setting.start, setting.judging)
    return float(np.sqrt(np.mean(left**2))) / problem.spread(setting.judging)
