"""What a diagnosis says in a terminal, and the words and numbers that it shares with the page."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camid.diagnosis.diagnosis import Coefficient, Diagnosis, Undetectable
from camid.diagnosis.explanation import LISTED_WEIGHT, rivals, wrong_coefficients
from camid.diagnosis.finding import Finding, ParameterEstimate
from camid.diagnosis.in_declared_units import UNITS_OF_STATE, in_declared_units
from camid.diagnosis.laws.learned_effect_file import NAME as LEARNED_EFFECT
from camid.diagnosis.learned_part import LearnedPart
from camid.diagnosis.weights import HEADLINE_WEIGHT, UNLISTED
from camid.number_text import SPACE, number, percentage, plain, printable, probability, span, with_deviation

if TYPE_CHECKING:
    from rich.table import Table

    from camid.simulation.model import Simulation

# Symbol, word and short meaning of a verdict: symbol and word say what the colour says.
VERDICT_WORDS = {
    "adequate": ("✓", "Adequate", "the simulation leaves nothing out that this recording shows"),
    "explained": ("◆", "Explained", "what the simulation leaves out is named, and what remains is noise"),
    "partly-explained": ("◐", "Partly explained", "something is named, and something structured remains"),
    "unexplained": ("?", "Unexplained", "something is left out, and this recording does not say what"),
}
# The meaning where no name reaches half of the weight.
WITHOUT_A_NAME = {
    "explained": "what the simulation leaves out is modelled but has several possible names, and what remains is noise",
    "partly-explained": "what is left out is modelled in part, has no name that is likely, and something remains",
}
# The same where all that is named changes the noise alone.
NOISE_ALONE = "of the motion nothing that shows is left out, and what changes the noise is named"
NOISE_BESIDE_COEFFICIENTS = "the coefficients were wrong, and what the simulation leaves out is of the noise alone"
CORRECTED = ("≠", "Coefficients were wrong", "the structure is right: re-estimated, it leaves out nothing that shows")
# Where nothing structured is left of an output of which nothing is explained.
HARDLY_ANYTHING = (
    "?",
    "Nothing explained",
    "the simulation explains hardly anything of the output, so that nothing can be said of its structure",
)
# Evidence of squares, which diagnosis.json holds and no reader is shown: the page speaks of root mean squares alone.
SQUARES = {"share", "validation_gain", "share_together"}
LIKELY = 0.95  # weight from which the alternatives to an effect are remote
BEYOND_CHANCE = 3.0  # standard deviations from which a constant is not zero
MOST_SHOWN = 3  # numbers of a parameter that has many, as those of an autoregression


# What is said of a name that only resembles the law that stands in its place.
NOT_SIMULATED = "not in the improved simulation: the law without a name stands in its place"
DOUBTFUL = "what is left out is modelled and what remains is noise, but something of it has no name that is likely"
NOT_CARRIED_OVER = "what the simulation leaves out is modelled in the rows that were fitted, and not in the others"
# Where a law without a name carries what the named ones leave, or all.
LEARNED_REST = "something is named, a law without a name was learned for what that leaves"
LEARNED_ALL = "what is left out has no name; a law was learned for it"


def verdict_words(diagnosis: Diagnosis) -> tuple[str, str, str]:
    """Symbol, word and short meaning of a diagnosis's verdict."""
    symbol, word, meaning = VERDICT_WORDS[diagnosis.verdict]
    if diagnosis.verdict == "explained" and not diagnosis.learned and _names_noise(diagnosis):
        wrong = wrong_coefficients(diagnosis.coefficients, diagnosis.fit)
        meaning = NOISE_BESIDE_COEFFICIENTS if wrong else NOISE_ALONE
    elif diagnosis.findings and diagnosis.findings[0].weight < HEADLINE_WEIGHT:
        meaning = WITHOUT_A_NAME[diagnosis.verdict]
    if diagnosis.verdict == "partly-explained" and not diagnosis.structured:
        meaning = DOUBTFUL if diagnosis.fit.carries_over else NOT_CARRIED_OVER
    if diagnosis.learned:
        meaning = LEARNED_REST if any(f.simulated for f in diagnosis.findings) else LEARNED_ALL
        meaning += ", and something remains" if diagnosis.structured else ", and what is left is noise"
    if meaning.endswith("is noise") and not diagnosis.fit.carries_over:
        meaning += " in the rows that were fitted"
    if needs_new_coefficients(diagnosis):
        symbol, word, meaning = CORRECTED
    if diagnosis.explains_nothing:
        symbol, word, meaning = HARDLY_ANYTHING
    if diagnosis.known_remainder is not None:
        size = plain(diagnosis.known_remainder, 3, diagnosis.compared_signal.symbol).replace(SPACE, " ")
        meaning = f"the simulation leaves out nothing beyond the declared remainder of {size} (root mean square)"
    return symbol, word, meaning


def _names_noise(diagnosis: Diagnosis) -> bool:
    """Whether all that is named changes the noise alone."""
    from camid.effects import known_effects

    return all(f.identifier in known_effects() and known_effects()[f.identifier].noise_like for f in diagnosis.findings)


def needs_new_coefficients(diagnosis: Diagnosis) -> bool:
    """Whether a simulation of the right structure had wrong coefficients."""
    if diagnosis.verdict != "adequate" or diagnosis.known_remainder is not None or diagnosis.fit.explains_nothing:
        return False
    return bool(wrong_coefficients(diagnosis.coefficients, diagnosis.fit))


def title_of(identifier: str, own: Mapping[str, str] | None = None) -> str:
    """An effect's title in the catalogue, or among a user's own."""
    from camid.effects import known_effects

    if identifier == UNLISTED:
        return "physics outside the catalogue"
    if own and identifier in own:
        return own[identifier]
    known = known_effects().get(identifier)
    words = identifier.replace("-", " ")
    return words[:1].upper() + words[1:] if known is None else known.title


def estimate_text(parameter: ParameterEstimate) -> str:
    """Value, standard deviation and unit, as they are shown, in one line."""
    if isinstance(parameter.value, str):
        return parameter.value
    if parameter.at_bound:
        return at_bound_text(parameter)
    if parameter.stated:
        return stated_text(parameter)
    if isinstance(parameter.value, list) and len(parameter.value) > MOST_SHOWN:
        deviations = parameter.standard_deviation
        some = deviations[:MOST_SHOWN] if isinstance(deviations, list) else deviations
        shown = with_deviation(parameter.value[:MOST_SHOWN], some, parameter.unit)
        return f"{shown}; … ({len(parameter.value)} numbers)"
    return with_deviation(parameter.value, parameter.standard_deviation, parameter.unit)


def at_bound_text(parameter: ParameterEstimate) -> str:
    """A number that a fit has left at its bound."""
    return f"{plain(float(parameter.value), unit=parameter.unit)} (at its bound)"


def stated_text(parameter: ParameterEstimate) -> str:
    """A number that was not estimated: others are counted by it."""
    return f"{plain(float(parameter.value), unit=parameter.unit)} (stated)"


def is_noise_only(evidence: dict[str, Any]) -> bool:
    """Whether an effect changes the noise and not the expected output, so that it removes no error."""
    return evidence.get("share") == 0.0 and evidence.get("validation_gain") is None


def evidence_lines(evidence: dict[str, Any], own: Mapping[str, str] | None = None) -> list[tuple[str, str]]:
    """Pairs of what was measured and its value: first the known kinds of evidence, then the others as they come."""
    lines = []
    known: dict[str, tuple[str, Callable[[float], str]]] = {
        "nrmse_without": ("error without it (RMS, held-out rows)", percentage),
        "false_alarm_probability": ("probability of as much by chance", probability),
        "delta_bic": ("ΔBIC against leaving it out", number),
        "delta_bic_to_next_best": ("ΔBIC to the next best", number),
    }
    noise_only = is_noise_only(evidence)
    if noise_only:
        lines.append(("error without it", "the same: it changes the noise"))
    for key, (words, text) in known.items():
        if isinstance(evidence.get(key), int | float):
            lines.append((words, text(float(evidence[key]))))
    for key, value in evidence.items():
        if key in SQUARES or (key in known and (value is None or isinstance(value, int | float))):
            continue
        if key == "next_best":
            if isinstance(value, str):
                lines.append(("next best", title_of(value, own)))
            continue
        if isinstance(value, bool) or value is None:
            shown = {True: "yes", False: "no", None: "–"}[value]
        elif isinstance(value, int | float):
            shown = number(float(value), 4) if isinstance(value, float) else str(value)
        else:
            shown = value if isinstance(value, str) else json.dumps(value, default=str, ensure_ascii=False)
        lines.append((key.replace("_", " "), shown))
    return lines


def not_found(diagnosis: Diagnosis) -> list[Undetectable]:
    """Effects that are neither found nor what those that are may be instead."""
    alternatives = {name for f in diagnosis.findings for name, weight in f.alternatives if weight >= LISTED_WEIGHT}
    return [u for u in diagnosis.undetectable if u.identifier not in alternatives]


def sorted_undetectable(
    undetectable: list[Undetectable], own: Mapping[str, str] | None = None
) -> tuple[list[Undetectable], list[Undetectable]]:
    """Those that would have shown, from a certain size on if they have one, and those that would not; by name."""
    ordered = sorted(undetectable, key=lambda u: title_of(u.identifier, own).lower())
    return [u for u in ordered if u.would_show], [u for u in ordered if not u.would_show]


def alternatives_text(finding: Finding, own: Mapping[str, str] | None = None) -> str:
    """The effects that cannot be told apart from a finding, with their weights."""
    return ", ".join(
        f"{title_of(name, own)} ({percentage(weight, 2)})"
        for name, weight in sorted(finding.alternatives, key=lambda pair: -pair[1])
        if weight >= LISTED_WEIGHT
    )


def place_text(diagnosis: Diagnosis) -> str:
    """Place, time, band and region of the mismatch in a line, in declared units as they are given."""
    location = diagnosis.location
    if diagnosis.explains_nothing:
        return "not to be said: the simulation explains hardly anything of the output"
    if location.place is None and diagnosis.verdict == "adequate":
        return "nowhere" if diagnosis.known_remainder is None else "not looked for within the declared remainder"
    parts = [location.place or "no place of the chain stands out"]
    if location.time is not None:
        parts.append(span(location.time, "s"))
    if location.frequency is not None:
        parts.append(span(location.frequency, "Hz"))
    if location.state is not None:
        parts.append(state_text(location.state, diagnosis.improved))
    return ", ".join(parts)


def state_text(state: tuple[str, float, float], simulation: Simulation) -> str:
    """Region of a signal, in declared units as it is given; positions are the plant's, and the sensor shifts them."""
    variable, low, high = state
    counted = " (counted from the rest)" if variable == "position" and simulation.known_offset else ""
    return f"{variable} from {span((low, high), simulation.units.text(UNITS_OF_STATE[variable]))}{counted}"


def _table_of_findings(diagnosis: Diagnosis) -> Table:
    from rich.table import Table

    table = Table(title="What was found", title_justify="left")
    for heading in ("effect", "weight", "place", "parameter", "value", "error without it"):
        table.add_column(heading, overflow="fold")
    for finding in diagnosis.findings:
        noise_only = is_noise_only(finding.evidence)
        without = "– (noise)" if noise_only else percentage(finding.evidence.get("nrmse_without"))
        rows = list(finding.parameters.items()) or [("", ParameterEstimate("–", None, ""))]
        for i, (name, parameter) in enumerate(rows):
            head = (finding.title, weight_text(finding), finding.place) if i == 0 else ("", "", "")
            value = estimate_text(parameter)
            table.add_row(*head, name.replace("_", " "), value, without if i == 0 else "")
    for part in diagnosis.learned:
        range_shown = span(part.visited or (part.learned.knots[0], part.learned.knots[-1]), part.knot_unit)
        values = f"{len(part.knots)} values, up to {plain(part.largest, unit=part.unit)} there"
        over = part.variables.rpartition(" over ")[2]
        table.add_row(part.name, "–", part.place, f"{over} {range_shown}", values, "–")
    return table


def _tables(diagnosis: Diagnosis) -> Iterator[Table]:
    if diagnosis.findings or diagnosis.learned:
        yield _table_of_findings(diagnosis)
    if diagnosis.coefficients:
        yield _table_of_coefficients(diagnosis)


def _table_of_coefficients(diagnosis: Diagnosis) -> Table:
    from rich.table import Table

    bent = bool(diagnosis.findings or diagnosis.learned)
    table = Table(title="Coefficients of the plant, old and new", title_justify="left")
    table.add_column("coefficient", overflow="fold")
    for heading in ("as given", "re-estimated", *(["with the effects"] if bent else [])):
        table.add_column(heading, justify="right", overflow="fold")
    table.add_column("unit", overflow="fold")
    for c in diagnosis.coefficients:
        values = [plain(c.nominal, 6), refitted_text(c)]
        values += [with_deviation(c.improved, c.improved_deviation)] if bent else []
        table.add_row(c.name, *values, c.unit)
    return table


def constants_text(simulation: Simulation) -> str | None:
    """Zero of the sensor and constant at the input that a diagnosis has estimated; None where none is beyond chance.

    Laws hold beside them: the edges of a dead zone lie about a constant that acts at the input.
    """
    units, found = simulation.units, []
    for name, unit, value, deviation in (
        ("the sensor's zero", "y", simulation.offset, simulation.offset_deviation),
        ("a constant at the input", "u", simulation.bias, simulation.bias_deviation),
    ):
        if isinstance(value, float) and deviation and abs(value) > BEYOND_CHANCE * deviation:
            shown = with_deviation(units.shown(value, unit), abs(units.shown(deviation, unit)), units.text(unit))
            found.append(f"{name}, {shown}")
    return f"estimated beside the coefficients: {'; '.join(found)}" if found else None


def refitted_text(coefficient: Coefficient) -> str:
    """A coefficient that was estimated without the effects; without a deviation where there is no such plant."""
    if coefficient.ran_away:
        return f"ran away ({number(coefficient.refitted, 2)})"
    return with_deviation(coefficient.refitted, coefficient.refitted_deviation)


def weight_text(finding: Finding) -> str:
    """Weight of a name; of one in whose place a law stands it is that of any law of such a kind."""
    weight = percentage(finding.weight, 2)
    return weight if finding.simulated else f"{weight} that it is such"


def stands_alone(finding: Finding) -> bool:
    """Whether the alternatives to a name are remote, or all fit worse with the catalogue's law."""
    as_good, worse = rivals(finding)
    return finding.weight >= LIKELY or bool(worse and not as_good)


def finding_lines(finding: Finding, own_titles: Mapping[str, str]) -> list[str]:
    """What a name cannot be told from, whether the improved simulation holds it, and what would decide."""
    lines = []
    others = alternatives_text(finding, own_titles)
    if others:
        relation = "not excluded:" if stands_alone(finding) else "cannot be told apart from:"
        lines.append(f"{finding.title} ({weight_text(finding)}), {relation} {others}")
    if not finding.simulated:
        lines.append(f"  {NOT_SIMULATED}")
    if finding.separating_experiment:
        lines.append(f"  what would: {finding.separating_experiment}")
    return lines


def learned_lines(part: LearnedPart) -> list[str]:
    """Formula and description of a law without a name."""
    lines = []
    if part.formula is not None:
        lines.append(f"formula: {part.formula.text}")
    lines += [f"formula, one of {len(part.rivals)}: {formula.text}" for formula in part.rivals]
    if part.description:
        lines.append(f"  in words: {part.description}")
    return lines


def print_summary(diagnosis: Diagnosis, written: list[Path]) -> None:
    """Print verdict, place, effects, errors and warnings for a person.

    Parameters
    ----------
    diagnosis : Diagnosis
    written : list of Path
        Files that hold the rest.
    """
    from rich.console import Console

    diagnosis = in_declared_units(diagnosis)
    # Names of files and columns may look like rich's markup.
    console = Console(highlight=False, markup=False, emoji=False)
    symbol, word, meaning = verdict_words(diagnosis)
    console.print(f"{symbol} {word.upper()}: {meaning}", style="bold", soft_wrap=True)
    console.print(printable(diagnosis.explanation), soft_wrap=True)
    console.print(f"located: {place_text(diagnosis)}", soft_wrap=True)
    for table in _tables(diagnosis):
        console.print(table)
    if constants := constants_text(diagnosis.improved):
        console.print(constants, soft_wrap=True)
    if explained := diagnosis.improved.units.explained:
        console.print(f"in units: {', '.join(explained)}", soft_wrap=True)
    for finding in diagnosis.findings:
        for line in finding_lines(finding, diagnosis.own_titles):
            console.print(line, soft_wrap=True)
    for part in diagnosis.learned:
        for line in learned_lines(part):
            console.print(printable(line), soft_wrap=True)
    fit = diagnosis.fit
    in_place = "" if fit.nominal_in_place is None else " (sensor's zero estimated)"
    console.print(
        f"error on held-out rows ({fit.rows}"
        f"{', chosen by camid' if fit.chosen else ''}), RMS in % of the output's standard deviation {fit.reference}: "
        f"as given {percentage(fit.as_given)}{in_place}, coefficients re-estimated {percentage(fit.refitted)}, "
        f"improved {percentage(fit.improved)}, noise floor {percentage(fit.noise_floor)}",
        soft_wrap=True,
    )
    if fit.position is not None:
        console.print(
            f"these errors are of the control ({printable(diagnosis.compared)}); of the position: re-estimated "
            f"{percentage(fit.position[0])}, improved {percentage(fit.position[1])}",
            soft_wrap=True,
        )
    others = not_found(diagnosis)
    unseen = len(others)
    if unseen:
        invisible = len(sorted_undetectable(others)[1])
        console.print(f"not found: {unseen} other effects, {invisible} of which would not have shown", soft_wrap=True)
    for path in written:
        console.print(f"written to {printable(str(path))}", soft_wrap=True)
        if path.name == LEARNED_EFFECT:
            console.print(
                f"  looks for what was learned in other recordings: --effects {printable(str(path))}", soft_wrap=True
            )
