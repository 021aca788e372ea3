"""A diagnosis in two to four plain sentences with the numbers in them; the first one says what matters most."""

from __future__ import annotations

from collections.abc import Sequence

from camid.diagnosis.diagnosis import Coefficient, Diagnosis, Location
from camid.diagnosis.finding import Finding, ParameterEstimate
from camid.diagnosis.in_declared_units import in_declared_units
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.normalised_errors import NormalisedErrors
from camid.diagnosis.swinging_coefficient import Swing
from camid.diagnosis.weights import HEADLINE_WEIGHT, UNLISTED
from camid.effects import known_effects
from camid.effects.special_cases import is_constant
from camid.number_text import SPACE, percentage, plain, with_deviation

# A simulation as given that errs more than the re-estimated one by this factor, with coefficients that are off by as
# many standard deviations, had wrong coefficients.
WRONG_ERROR_RATIO = 1.5
WRONG_DEVIATIONS = 3.0
# Weight below which a name is no description either.
RESEMBLANCE = 0.1
# Weight of all other names up to which two findings are said to be two effects or one.
MOST_BESIDE = 0.15
# Weight below which one of several names is not listed among them.
LISTED_WEIGHT = 0.005
# Weight from which a rival of a sure name is told of, and how much worse than the name it fits (difference of Bayes's
# criterion, very strong evidence; Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773-795) where only its name is left.
RIVAL_WEIGHT = 0.02
FITS_WORSE = 10.0
# Coefficients that a sentence lists.
MOST_COEFFICIENTS = 3


def wrong_coefficients(coefficients: Sequence[Coefficient], fit: NormalisedErrors) -> list[Coefficient]:
    """Coefficients whose nominal values were wrong, the farthest off first; none where they cost little."""
    if fit.as_given < WRONG_ERROR_RATIO * fit.refitted:
        return []

    def off(coefficient: Coefficient) -> float:
        difference, deviation = abs(coefficient.nominal - coefficient.improved), coefficient.improved_deviation
        return difference / deviation if deviation > 0.0 else 0.0

    return sorted((c for c in coefficients if off(c) > WRONG_DEVIATIONS), key=lambda c: -off(c))


def headline(finding: Finding) -> str:
    """What a finding may be called: its name, the class that it is one of, or what it acts like."""
    listed = [(finding.title, finding.weight)]
    listed += [
        (known_effects()[name].title, weight)
        for name, weight in finding.alternatives
        if name != UNLISTED and weight >= LISTED_WEIGHT
    ]
    if finding.weight >= HEADLINE_WEIGHT:
        return f"{finding.title}{_details(finding)}"
    if finding.named >= HEADLINE_WEIGHT and len(listed) > 1:
        ordered = sorted(listed, key=lambda pair: -pair[1])
        names = [f"{within_sentence(title)} ({_share(weight, 2)})" for title, weight in ordered]
        return f"one of {', '.join(names[:-1])} or {names[-1]}"
    if known_effects()[finding.identifier].noise_like:
        return (
            f"what looks like {within_sentence(finding.title)}{_details(finding)}, or is the shadow of something else"
        )
    if finding.weight < RESEMBLANCE:
        return f"physics outside the catalogue at the {finding.place}"
    acts = f"which acts like {within_sentence(finding.title)}{_details(finding, ' that it is this')}"
    return f"physics outside the catalogue, {acts}"


def explained(diagnosis: Diagnosis) -> str:
    """A diagnosis in sentences, in the units that the simulation declares."""
    shown = in_declared_units(diagnosis)
    return explanation(
        shown.verdict,
        shown.findings,
        shown.fit,
        shown.location,
        shown.coefficients,
        shown.known_remainder,
        shown.learned,
        shown.structured,
        diagnosis.compared_signal.symbol,
        shown.swing,
    )


def explanation(
    verdict: str,
    found: Sequence[Finding],
    fit: NormalisedErrors,
    location: Location,
    coefficients: Sequence[Coefficient] = (),
    remainder: float | None = None,
    learned: Sequence[LearnedPart] = (),
    structured: bool = False,
    unit: str = "",
    swing: Swing | None = None,
) -> str:
    """Plain sentences with the numbers in them, in the units that stand with them.

    Parameters
    ----------
    verdict : str
    found : sequence of Finding
    fit : NormalisedErrors
    location : Location
    coefficients : sequence of Coefficient
    remainder : float, optional
        Root mean square of what the simulation declares to be unexplained, where the verdict rests on it.
    learned : sequence of LearnedPart
        Laws without a name.
    structured : bool
        Whether what all of them leave is more than noise.
    unit : str
        Of the remainder.
    swing : Swing, optional
        Of a coefficient in time, which what is left shows.
    """
    if remainder is not None:
        declared = plain(remainder, 3, unit).replace(SPACE, " ")
        return (
            f"Nothing is left out beyond what an earlier diagnosis left unexplained: the simulation declares a "
            f"remainder of {declared} (root mean square), and with its coefficients re-estimated it leaves no "
            f"more than that: {_share(fit.refitted)} of the output's standard deviation on rows that were not fitted. "
            f"Remove the key remainder to have that looked into again."
        )
    sentences = []
    noise = [f for f in found if known_effects()[f.identifier].noise_like]
    motion = [f for f in found if f not in noise]
    names_noise = not motion
    held = any(f.simulated for f in motion)
    if fit.explains_nothing:
        sentences.append(
            f"The simulation explains hardly anything of the output: at its best it leaves {_share(fit.improved)} of "
            f"the output's standard deviation on rows that were not fitted."
        )
    if verdict == "adequate":
        sentences += _of_no_structure(fit) if fit.explains_nothing else _adequate(fit, coefficients)
    elif verdict == "unexplained":
        left = "what is left is structured" if structured else "in the fitted rows what is left is noise"
        sentences.append(
            f"Something is left out, and no effect of the catalogue explains it: re-estimating the coefficients leaves "
            f"{_share(fit.refitted)} of the output's standard deviation on rows that were not fitted (the noise in the "
            f"fitted ones is estimated as {_share(fit.noise_floor)}), and {left}."
        )
    elif found and names_noise and not learned:
        sentences += _of_noise_alone(found, fit, coefficients)
    elif held:
        sentences.append(_named(found, fit))
    else:
        sentences.append(
            f"Something is left out that no effect of the catalogue explains. On rows that were not fitted the error "
            f"{_falls(fit)}."
        )
    if location.place and verdict != "adequate":
        sentences.append(_sits(location.place, of_noise=bool(found) and names_noise and not learned))
    if learned:
        sentences.append(_held(motion, learned))
        sentences += _beside_laws([] if held else noise, structured=structured)
    elif structured and verdict == "partly-explained":
        sentences.append("What is left is still structured, so something else is missing, too, or the law is another.")
    elif verdict == "partly-explained" and fit.carries_over:
        sentences.append("What is left is noise, but it is likelier than not that something here has another name.")
    sentences += _beyond(fit, swing, carried=verdict == "adequate" or structured or fit.carries_over)
    return " ".join(sentences + _indistinct(found))


def _beyond(fit: NormalisedErrors, swing: Swing | None, *, carried: bool) -> list[str]:
    """What else is said of what is left: a coefficient that swings, and rows that were not fitted."""
    sentences = []
    if swing is not None:
        at = with_deviation(swing.angular, swing.deviation, "rad/s").replace(SPACE, " ")
        sentences.append(
            f"It shows a coefficient that swings in time, {swing.name} at {at}, as where something that turns changes "
            f"it; no effect of the catalogue does that."
        )
    if not carried:
        times = plain(fit.improved / fit.noise_floor, 2)
        sentences.append(
            f"That is said of the rows that were fitted: in the others the error is {times} times the noise, so that "
            f"the laws or their coefficients are not exact there."
        )
    return sentences


def _sits(place: str, *, of_noise: bool) -> str:
    """Where it is; of an effect on the noise alone the mismatch may have been that of the coefficients."""
    return f"{'It' if of_noise else 'The mismatch'} sits at the {place}."


def _adequate(fit: NormalisedErrors, coefficients: Sequence[Coefficient]) -> list[str]:
    listed = "What the recording could not have shown is listed."
    wrong = wrong_coefficients(coefficients, fit)
    if wrong:
        return [*_corrected(wrong, fit), "Nothing else is left out that this recording could show.", listed]
    return [
        f"Nothing is left out that this recording could show: with its coefficients re-estimated the simulation "
        f"leaves {_left(fit)}.",
        listed,
    ]


def _of_no_structure(fit: NormalisedErrors) -> list[str]:
    """What is said where nothing structured is left of an output of which nothing is explained."""
    return [
        "So nothing can be said of its structure: what it leaves shows none, and neither would an output that has "
        "nothing to do with this input.",
        f"As given{_in_place(fit)}, the simulation leaves {_share(fit.as_given)}; re-estimated, "
        f"{_share(fit.refitted)}, and the noise alone is {_share(fit.noise_floor)}.",
        "Is the right column compared, did the rig move, and was it driven by this input?",
    ]


def _in_place(fit: NormalisedErrors) -> str:
    return "" if fit.nominal_in_place is None else " but for the sensor's zero"


def _of_noise_alone(found: Sequence[Finding], fit: NormalisedErrors, coefficients: Sequence[Coefficient]) -> list[str]:
    """What is said where nothing of the motion is left out: effects on the noise take no error away."""
    wrong = wrong_coefficients(coefficients, fit)
    noise = f"The simulation leaves out, of the noise alone: {_listed(found)}."
    return [*_corrected(wrong, fit), noise] if wrong else [f"Re-estimated, it leaves {_left(fit)}.", noise]


def _corrected(wrong: Sequence[Coefficient], fit: NormalisedErrors) -> list[str]:
    """Which coefficients were wrong, and what that cost."""
    values = [f"{c.name} is {_estimate(c)} and not {plain(c.nominal, 4)}" for c in wrong[:MOST_COEFFICIENTS]]
    more = len(wrong) - len(values)
    if more:
        values.append(f"{more} more {'is' if more == 1 else 'are'} off")
    return [
        f"The structure is right and the coefficients were wrong: {', '.join(values)}.".replace(SPACE, " "),
        f"As given{_in_place(fit)}, the simulation leaves {_share(fit.as_given)}; re-estimated, it leaves "
        f"{_left(fit)}.",
    ]


def _left(fit: NormalisedErrors) -> str:
    return (
        f"{_share(fit.refitted)} of the output's standard deviation on rows that were not fitted, and the noise alone "
        f"{_share(fit.noise_floor)}"
    )


def _named(found: Sequence[Finding], fit: NormalisedErrors) -> str:
    return f"The simulation leaves out: {_listed(found)}. On rows that were not fitted the error {_falls(fit)}."


def _listed(found: Sequence[Finding]) -> str:
    together = _together(found)
    names = [headline(finding) for finding in found]
    if together is not None:
        (one, other), said = together
        names = [said if i == one else name for i, name in enumerate(names) if i != other]
    return f"{'; '.join(names[:-1])}; and {names[-1]}" if len(names) > 1 else names[0]


def _together(found: Sequence[Finding]) -> tuple[tuple[int, int], str] | None:
    """Two findings that are together exactly one effect which is in both their classes, and what to say of them."""
    for law in (law for law in known_effects().values() if law.sum_of):
        both = [i for i, f in enumerate(found) if dict(f.alternatives).get(law.identifier, 0.0) >= RESEMBLANCE]
        parts = sorted((found[i] for i in both), key=lambda f: is_constant(f.identifier))
        # A constant elsewhere stands for the one that the law is the sum with.
        if len(parts) != 2 or parts[0].identifier not in law.sum_of or not is_constant(parts[1].identifier):
            continue
        if any(f.weight >= HEADLINE_WEIGHT or _rest(f, law.identifier) >= MOST_BESIDE for f in parts):
            continue
        share = dict(parts[0].alternatives)[law.identifier]
        names = " and ".join(within_sentence(finding.title) for finding in parts)
        one, other = f"{names} ({_share(parts[0].weight, 2)})", f"{within_sentence(law.title)} ({_share(share, 2)})"
        return (both[0], both[1]), f"either {one} or {other}, which no input tells apart"
    return None


def _rest(finding: Finding, identifier: str) -> float:
    """Weight of all that a finding may be but for its own name, one other and physics outside the catalogue."""
    return sum(weight for name, weight in finding.alternatives if name not in {identifier, UNLISTED})


def _held(found: Sequence[Finding], learned: Sequence[LearnedPart]) -> str:
    """What the improved simulation holds of laws without a name, and in whose place."""
    laws = " and ".join(
        f"a {within_sentence(part.name)}{'' if part.curve is None else ' as a formula'}" for part in learned
    )
    replaced = [within_sentence(finding.title) for finding in found if not finding.simulated]
    if replaced:
        names = " and ".join(replaced)
        return f"The improved simulation holds {laws}, in the place of {names}, which only resembles the law."
    if not found:
        return f"The improved simulation holds {laws}."
    return (
        f"The improved simulation also holds {laws}: what the laws above have inexactly, or something that has no "
        f"name here."
    )


def _beside_laws(noise: Sequence[Finding], *, structured: bool) -> list[str]:
    """What laws without a name leave, and what is found on the noise where they are all that is found of the motion."""
    left = f"What is left beside it is {'still structured' if structured else 'noise'}."
    return [left, *([f"The simulation leaves out, of the noise alone, too: {_listed(noise)}."] if noise else [])]


def _falls(fit: NormalisedErrors) -> str:
    falls = "falls" if fit.improved < fit.refitted else "rises"
    return (
        f"{falls} from {_share(fit.refitted)} (coefficients re-estimated) to {_share(fit.improved)} of the output's "
        f"standard deviation; noise alone is {_share(fit.noise_floor)}"
    )


def _indistinct(found: Sequence[Finding]) -> list[str]:
    """What the first finding with a sure name and rivals cannot be told from, and which rivals have its name alone."""
    for finding in found:
        as_good, worse = rivals(finding)
        if finding.weight < HEADLINE_WEIGHT or not (as_good or worse):
            continue
        own = within_sentence(finding.title)
        said = [f"This recording cannot tell {own} from {_either(as_good)}."] if as_good else []
        if worse:
            share = _share(sum(w for n, w in finding.alternatives if n in worse), 2)
            said.append(
                f"{_either(worse, capital=True)} fits worse with the catalogue's law, and is not excluded with another "
                f"one ({share})."
            )
        return said
    return []


def rivals(finding: Finding) -> tuple[list[str], list[str]]:
    """Identifiers of rivals of a name that fit about as well, and of those that fit worse with the catalogue's law."""
    names = [n for n, weight in finding.alternatives if n != UNLISTED and weight >= RIVAL_WEIGHT]
    gaps: dict[str, float] = {}
    for member in finding.comparison.members if finding.comparison else ():
        gaps[member.identifier] = min(member.gap, gaps.get(member.identifier, member.gap))
    own = gaps.get(finding.identifier, 0.0)
    worse = [name for name in names if gaps.get(name, 0.0) - own >= FITS_WORSE]
    return [name for name in names if name not in worse], worse


def _either(names: Sequence[str], capital: bool = False) -> str:
    """Titles of effects, of which it is one."""
    titles = [within_sentence(known_effects()[name].title) for name in names]
    listed = f"{', '.join(titles[:-1])} or {titles[-1]}" if len(titles) > 1 else titles[0]
    return listed[:1].upper() + listed[1:] if capital else listed


def _share(value: float, digits: int = 3) -> str:
    return percentage(value, digits).replace(SPACE, " ")


def within_sentence(title: str) -> str:
    """A title within a sentence, without what explains it: names of people keep their capital."""
    title = title.partition(" (")[0]
    return title if title.split(maxsplit=1)[0] in PEOPLE else title[:1].lower() + title[1:]


# First words of titles that are names.
PEOPLE = {"Coulomb", "Stribeck"}


def _estimate(coefficient: Coefficient) -> str:
    return with_deviation(coefficient.improved, coefficient.improved_deviation, coefficient.unit)


def _details(finding: Finding, of_weight: str = "") -> str:
    """What it is of, the leading parameter, and the weight of what.

    The first number leads that is determined, and not one of which nothing is shown; before it the size, if it is not.
    """
    parts = [] if finding.weight >= 0.995 else [f"{_share(finding.weight, 2)}{of_weight}"]
    # What ended at its bound is no number that leads.
    numbers = {n: p for n, p in finding.parameters.items() if isinstance(p.value, float) and not p.at_bound}
    shown = [name for name, p in numbers.items() if p.standard_deviation is not None]
    leading = next((name for name in (*shown, *numbers) if _is_determined(numbers[name])), next(iter(numbers), None))
    size = known_effects()[finding.identifier].strength
    doubtful = [size] if size in shown and not _is_determined(numbers[size]) else []
    named = dict.fromkeys([*doubtful, *([leading] if leading is not None else [])])
    parts[:0] = [f"{name.replace('_', ' ')} {_shown(numbers[name])}" for name in named]
    first = next(iter(finding.parameters.values()), None)
    if first is not None and isinstance(first.value, str):
        parts.insert(0, first.value)
    return f" ({'; '.join(parts)})" if parts else ""


def _is_determined(parameter: ParameterEstimate) -> bool:
    """Whether a number is larger than its standard deviation."""
    deviation = parameter.standard_deviation
    return deviation is None or abs(float(parameter.value)) >= deviation


def _shown(parameter: ParameterEstimate) -> str:
    """A number with its standard deviation, unit and, where that is so, the remark that it is not determined."""
    value, deviation = float(parameter.value), parameter.standard_deviation
    if deviation is None:
        return f"about {plain(value, unit=parameter.unit)}".replace(SPACE, " ")
    shown = with_deviation(value, deviation, parameter.unit).replace(SPACE, " ")
    return shown if _is_determined(parameter) else f"not determined, {shown}"
